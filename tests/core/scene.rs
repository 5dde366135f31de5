//! Scenes: the shipped ones are sound, errors name their place, seeds give the same bits.

use std::hash::{DefaultHasher, Hash, Hasher};

use carom::scene::{Scene, file, shipped};

fn error(text: &str) -> String {
    file::parse(text, "scene.yaml").expect_err("refused").to_string()
}

#[test]
fn shipped_scenes_load_and_run() {
    for name in shipped::names() {
        let scene = Scene::load(name).unwrap_or_else(|error| panic!("{error}"));
        let mut world = scene.world();
        let instants = carom::world::Instants { heard_at: 0.0, advance_to: 0.5 };
        assert_eq!(world.step(&[], instants).stall, None, "{name}");
        let (file, _) = shipped::find(name).expect("shipped");
        assert!(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(file).exists());
    }
    assert_eq!(Scene::load("thousand").expect("shipped").pucks.len(), 1000);
}

#[test]
fn every_file_in_config_is_shipped() {
    let config = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("config");
    for entry in config.read_dir().expect("config") {
        let path = entry.expect("entry").path();
        if path.extension().is_some_and(|e| e == "yaml") {
            let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
            assert!(shipped::find(&name).is_some(), "{name}");
        }
    }
}

#[test]
fn errors_name_file_line_and_key() {
    let puck = "{name: a, position: [1, 1], radius: 0.5}";
    let cases = [
        ("restitution: 1.5", "scene.yaml:1:14: restitution = 1.5, must be from 0 to 1"),
        ("restitution: -.inf", "scene.yaml:1:14: restitution = -inf, must be from 0 to 1"),
        (
            "node:\n  publish_rate_hz: 0",
            "scene.yaml:2:20: publish_rate_hz = 0, must be 0.001 to 100000",
        ),
        ("node: {stale_after_s: .nan}", "scene.yaml:1:23: stale_after_s = NaN, must be above 0"),
        (
            "walls: {x: [2, 1], y: [0, 1]}",
            "scene.yaml:1:8: walls: x and y must be [low, high] with low below high, within 1e60 m",
        ),
        (
            "pucks:\n  - {name: a, position: [1, 1], radius: -0.5}",
            "scene.yaml:2:5: puck `a`: radius = -0.5, must be above 0 m",
        ),
        (
            "pucks:\n  - {name: a, position: [.nan, 1], radius: 0.5}",
            "scene.yaml:2:5: puck `a`: x = NaN, must be a finite number",
        ),
        (
            "pucks:\n  - {name: a/b, position: [1, 1], radius: 0.5}",
            "scene.yaml:2:12: name `a/b`: letters, digits and single _, not beginning with a digit",
        ),
        (
            "pucks:\n  - {name: a, position: [1, 1], radius: 0.5, colour: mauvish}",
            "scene.yaml:2:54: colour `mauvish`: a CSS colour such as \"#d62728\"",
        ),
        (
            "walls: {x: [0, 2], y: [0, 2]}\npucks:\n  - {name: a, position: [0.4, 1], radius: 0.5}",
            "scene.yaml:3:5: puck `a` must lie inside the walls",
        ),
        (
            "batches: [{name: b, count: 2, radius: 1}]",
            "scene.yaml:1:11: a batch without walls needs a `region`",
        ),
        (
            "node: {circle_topics: [\"a b\"]}",
            "scene.yaml:1:23: circle_topics: `a b` is not a topic name",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(error(text), expected, "{text}");
    }
    assert!(error("node: {publish_rate_hz: 1.0e+9}").contains("must be 0.001 to 100000"));
    assert!(error("node: {circle_topics: [a, /a]}").contains("`/a` stands there twice"));
    let with_id = |id: u32| format!("pucks: [{{name: a, position: [0, 0], radius: 1, id: {id}}}]");
    assert!(error(&with_id(u32::MAX)).contains("stands for a wall"));
    let late = "batches: [{name: g_, count: 2, radius: 1, region: {x: [0, 9], y: [0, 9]}}]";
    assert!(error(late).contains("must not end with _"));
    assert!(!error("restitution: []").contains("at line"), "the place is named once");
    let two = |second: &str| error(&format!("pucks:\n  - {puck}\n  - {second}"));
    assert_eq!(two(puck), "scene.yaml:3:12: the name `a` is taken");
    assert_eq!(
        two("{name: b, position: [1.5, 1], radius: 0.5}"),
        "scene.yaml:3:5: puck `b` overlaps puck `a`: part them, or let them just touch"
    );
    let jam = "batches: [{name: b, count: 9, radius: 1, region: {x: [0, 4], y: [0, 4]}}]";
    assert!(error(jam).contains("pucks found a place; fewer or smaller"), "{}", error(jam));
}

#[test]
fn errors_of_yaml_are_one_line_with_a_place() {
    for text in [
        "restitushun: 1",
        "restitution: fast",
        "walls: [",
        "pucks: {}",
        "pucks: [{name: a}]",
        "a: &a [*a]",
        "name: x\nname: y",
    ] {
        let message = error(text);
        assert!(message.starts_with("scene.yaml:") && !message.contains('\n'), "{message}");
        assert!(message[11..].starts_with(|c: char| c.is_ascii_digit()), "{message}");
    }
    assert!(error("restitushun: 1").contains("restitushun"));
    let missing = Scene::load("no/such/scene.yaml").expect_err("missing").to_string();
    assert!(missing.contains("no/such/scene.yaml") && missing.contains("arena"), "{missing}");
}

#[test]
fn large_batches_load_quickly_and_larger_ones_are_refused() {
    let batch = |count: usize| {
        format!(
            "batches: [{{name: g, count: {count}, radius: 0.01, \
             region: {{x: [0, 99], y: [0, 99]}}}}]"
        )
    };
    let start = std::time::Instant::now();
    let scene = file::parse(&batch(200_000), "scene.yaml").expect("sound");
    assert_eq!(scene.pucks.len(), 200_000);
    assert!(start.elapsed().as_secs_f64() < 2.0, "{:?}", start.elapsed());
    assert!(error(&batch(200_001)).contains("at most 200000 pucks"));
}

#[test]
fn endless_files_are_refused() {
    let error = Scene::load("/dev/zero").expect_err("endless").to_string();
    assert!(error.contains("larger than"), "{error}");
}

#[test]
fn touching_pucks_are_allowed_and_infinite_mass_is_fixed() {
    let text = "pucks:\n  - {name: a, position: [0, 0], radius: 0.5, mass: .inf}\n  \
                - {name: b, position: [1, 0], radius: 0.5, id: 3}";
    let scene = file::parse(text, "scene.yaml").expect("sound");
    assert_eq!(scene.pucks.iter().map(|p| p.disc.id).collect::<Vec<_>>(), [3, 1_000_000]);
    assert!(scene.pucks[1].disc.mass.is_infinite() && scene.pucks[0].driven);
}

#[test]
fn batches_stand_where_segments_let_them() {
    let box_of_lines = "segments: {lines: [{name: box, closed: true, points: [[0, 0], [4, 0], \
                        [4, 3], [0, 3]]}]}\nbatches: [{name: g, count: 40, radius: 0.05, speed: 1, \
                        region: {x: [-2, 6], y: [-2, 5]}}]";
    let scene = file::parse(box_of_lines, "box").unwrap();
    assert_eq!(scene.pucks.len(), 40);
    for puck in &scene.pucks {
        let at = puck.disc.position;
        let within = |x: f64, side: f64| x > 0.05 - 1e-9 && x < side - 0.05 + 1e-9;
        assert!(within(at.x, 4.0) && within(at.y, 3.0), "{at}");
    }
}

/// Hash of every bit of the pucks of a scene.
fn fingerprint(scene: &Scene) -> u64 {
    let mut hasher = DefaultHasher::new();
    for puck in &scene.pucks {
        let d = &puck.disc;
        let numbers = [d.position.x, d.position.y, d.velocity.x, d.velocity.y, d.radius, d.mass];
        numbers.map(f64::to_bits).hash(&mut hasher);
    }
    hasher.finish()
}

#[test]
fn a_seed_gives_the_same_bits() {
    let batch = |seed: u64| {
        let text = format!(
            "walls: {{x: [0, 9], y: [0, 9]}}\nbatches: [{{name: b, count: 50, seed: {seed}, \
             radius: [0.1, 0.4], mass: [1, 2], speed: 1}}]"
        );
        fingerprint(&file::parse(&text, "scene.yaml").expect("sound"))
    };
    assert_eq!(batch(1), batch(1));
    assert_ne!(batch(1), batch(2));
}

#[test]
fn gravity_and_periodic_boxes_are_read_or_refused() {
    let puck = "pucks: [{name: a, position: [1, 1], radius: 0.5}]\n";
    let parse = |keys: &str| file::parse(&format!("{puck}{keys}"), "scene.yaml");
    let tilted = parse("gravity: [0.0, -9.81]").expect("a scene").settings;
    assert_eq!(tilted.gravity, Some(glam::DVec2::new(0.0, -9.81)));
    let periodic = parse("periodic: {x: [0, 4], y: [0, 3]}").expect("a scene").settings.periodic;
    assert_eq!(periodic.expect("a box").size(), glam::DVec2::new(4.0, 3.0));
    let refused = [
        ("gravity: [.nan, 0]", "gravity: [x, y] in m/s^2, each 0 or of a size from 1e-30 to 1e30"),
        ("periodic: {x: [0, 2], y: [0, 9]}", "periodic: must be wider than 4.001 radii, 2.0005 m"),
        (
            "walls: {x: [0, 4], y: [0, 4]}\nperiodic: {x: [0, 4], y: [0, 4]}",
            "periodic: x and y only, without walls and without gravity",
        ),
        (
            "gravity: [0, 1]\nperiodic: {x: [0, 4], y: [0, 4]}",
            "periodic: x and y only, without walls and without gravity",
        ),
    ];
    for (keys, message) in refused {
        let error = parse(keys).expect_err("refused").to_string();
        assert!(error.ends_with(message) && error.lines().count() == 1, "{error}");
    }
}

#[test]
fn as_many_pucks_may_be_listed_as_a_scene_may_have() {
    let puck = |k: u32| {
        let (x, y) = (k % 200, k / 200);
        format!("  - {{name: p{k}, position: [{x}, {y}], velocity: [1, 0], radius: 0.25}}\n")
    };
    let text: String = (0..20_000).map(puck).collect();
    let scene = file::parse(&format!("pucks:\n{text}"), "scene.yaml").expect("few enough");
    assert_eq!(scene.pucks.len(), 20_000);
}

#[test]
fn an_error_about_a_name_is_one_short_line() {
    for name in ["x\\ny\\e[31m".to_owned(), "a".repeat(3_000)] {
        let text = format!("pucks:\n  - {{name: \"{name}\", position: [1, 1], radius: 0.5}}");
        let error = error(&text);
        assert!(error.len() < 250 && error.chars().all(|c| !c.is_control()), "{error:?}");
    }
}

#[test]
fn a_pipe_is_not_waited_for() {
    // What a process has open is a pipe here: the test reads from one.
    let (_reader, writer) = std::io::pipe().expect("a pipe");
    let path = format!("/proc/self/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&writer));
    let error = Scene::load_without_waiting(&path).expect_err("refused").to_string();
    assert!(error.ends_with("neither a file nor the name of a scene"), "{error}");
}
