//! The Rust mirrors and the .msg files say the same, field by field.

use std::path::Path;

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

type Words = Vec<(String, String)>;

/// `(type, name)` of each field of a .msg file, and its constants with their values.
fn msg_fields(text: &str) -> (Words, Words) {
    let (mut fields, mut constants) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let (code, comment) = line.split_once('#').unwrap_or((line, ""));
        let Some((kind, name)) = code.trim().split_once(char::is_whitespace) else { continue };
        assert!(!comment.trim().is_empty(), "a field without unit and meaning: {line}");
        match name.split_once('=') {
            Some((name, value)) => constants.push((name.trim().into(), value.trim().into())),
            None => fields.push((kind.to_owned(), name.trim().to_owned())),
        }
    }
    (fields, constants)
}

/// `(type, name)` of each field of a mirror, in the words of a .msg file.
fn mirror_fields(source: &str, name: &str) -> Words {
    let start = format!("pub struct {name} {{");
    let body = source.split_once(&start).unwrap_or_else(|| panic!("no mirror of {name}")).1;
    let body = body.split_once('}').expect("an end").0;
    let fields = body.lines().filter_map(|line| line.trim().strip_prefix("pub "));
    fields
        .map(|field| {
            let (name, kind) = field.trim_end_matches(',').split_once(": ").expect("a type");
            (ros_type(kind), name.to_owned())
        })
        .collect()
}

fn ros_type(kind: &str) -> String {
    match kind {
        "u32" => "uint32".into(),
        "u64" => "uint64".into(),
        "f64" => "float64".into(),
        "bool" => "bool".into(),
        "String" => "string".into(),
        "Header" => "std_msgs/Header".into(),
        _ => match kind.strip_prefix("Vec<").and_then(|rest| rest.strip_suffix('>')) {
            Some(element) => format!("{}[]", ros_type(element)),
            None => kind.to_owned(),
        },
    }
}

#[test]
fn mirrors_agree_with_the_msg_files() {
    let source = read("src/messages.rs");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("msg");
    let mut count = 0;
    for entry in folder.read_dir().expect("msg/") {
        let path = entry.expect("entry").path();
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let (fields, constants) = msg_fields(&read(&format!("msg/{name}.msg")));
        assert_eq!(fields, mirror_fields(&source, &name), "{name}");
        for (constant, value) in constants {
            assert_eq!(
                (constant.as_str(), value.parse()),
                ("WALL", Ok(carom::messages::Contact::WALL))
            );
        }
        assert!(read("CMakeLists.txt").contains(&format!("msg/{name}.msg")), "{name} is built");
        count += 1;
    }
    assert_eq!(count, 9);
}
