//! The command line: exit codes, one clear line for an error, an end when asked for.

use std::io::{BufRead, BufReader};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn carom(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command
        .args(arguments)
        .env("ROS_DOMAIN_ID", "78")
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .env_remove("ROS_LOCALHOST_ONLY")
        .env_remove("RUST_LOG")
        .stdin(Stdio::null());
    command
}

fn output(arguments: &[&str]) -> Output {
    carom(arguments).output().expect("the program was built")
}

/// The only line on stderr of a refused call.
fn refusal(command: &mut Command) -> String {
    let output = command.output().expect("the program was built");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert_eq!(text.lines().count(), 1, "{text}");
    text
}

#[test]
fn the_wire_is_for_leagues_and_says_what_it_needs() {
    let cases: [(&[&str], &str); 9] = [
        (&["arena", "--wire"], "which league is arena of? say --wire=ssl or --wire=vsss"),
        (&["arena", "--wire=ssl"], "arena has no `field`: run ssl-a"),
        (&["ssl-b", "--wire=fifa"], "[possible values: auto, ssl, vsss]"),
        (&["ssl-b", "--vision", "127.0.0.1:1"], "--wire"),
        (&["ssl-b", "--wire", "--wire-ports", "1,2,3,4,5"], "SSL has three, four or six"),
        (&["vsss-3v3", "--wire", "--wire-ports", "1,2,3"], "VSSS has one"),
        (&["vsss-3v3", "--wire", "--cameras", "2"], "VSSS has neither"),
        (&["ssl-b", "--wire", "--cameras", "3"], "must be 1, 2, 4 or 8"),
        (&["ssl-b", "--wire", "--vision-noise", "1,nan,0"], "must be three numbers from 0 to 10"),
    ];
    for (arguments, expected) in cases {
        let text = refusal(&mut carom(arguments));
        assert!(text.starts_with("carom: ") && text.contains(expected), "{arguments:?}: {text}");
    }
}

#[test]
fn bad_use_is_one_line_and_exit_code_2() {
    let cases: [(&[&str], &str); 25] = [
        (&["run", "arena", "--step", "0.01"], "--step: method events has no step; leave it out"),
        (&["replay", "bag", "--rate", "-1"], "'--rate <FACTOR>': must be a number of 0 or more"),
        (&["audit", "bag", "--crash-speed", "-1"], "'--crash-speed <MPS>': must be a number of 0"),
        (&["bench", "gas", "--discs", "-5"], "-5 is not in 4..=10000000"),
        (&["bench", "gas", "--area-fraction", "1e-12"], "must be a number from 1e-6 to below 0.9"),
        (&["bench", "gas", "--discs", "4"], "a periodic box has 8 discs at least"),
        (&["bench", "gas", "--melt", "1e30"], "must be a number from 0 to 1e6"),
        (&["bench", "gas", "--step", "1e300"], "must be a number of seconds above 0, up to 1"),
        (&["bench", "gas", "--method", "springs"], "take steps, or --boundary walls"),
        (
            &["resolver", "--ros-args", "-p", "robots:=[r1]", "-p", "r1.radius:=-1.0"],
            "'r1.radius': -1 is not in 1e-60 to 1e60",
        ),
        (&["run", "--record", "/proc/none/bag"], "/proc/none/bag: cannot be made: "),
        (&["record", "/clock", "-o", "/proc/none/bag"], "/proc/none/bag: cannot be made: "),
        (&["run", "--error", "0"], "'--error <E>': must be a number above 0, such as 1e-6"),
        (&["run", "--budget", "1h"], "'--budget <TIME>': must be a time above 0, such as 2ms"),
        (&["run", "nosuch"], "nosuch: No such file"),
        (&["nosuch.yaml"], "nosuch.yaml: No such file"),
        (&["run", "--rate", "-1"], "'--rate <FACTOR>': must be a number of 0 or more"),
        (&["run", "--rate", "fast"], "'--rate <FACTOR>': must be a number of 0 or more"),
        (&["run", "--for", "0"], "'--for <SECONDS>': must be a number of seconds above 0"),
        (&["run", "--for", "inf"], "'--for <SECONDS>': must be a number of seconds above 0"),
        (&["run", "--method", "fast"], "invalid value 'fast' for '--method <M>'"),
        (&["run", "--step", "0"], "'--step <S>': must be a number of seconds above 0"),
        (
            &["run", "teams", "--method", "springs"],
            "teams: method springs does not do restitution; leave it out and set damping",
        ),
        (&["--frob"], "unexpected argument '--frob'"),
        (&["run", "arena", "head_on"], "unexpected argument 'head_on'"),
    ];
    for (arguments, expected) in cases {
        let text = refusal(&mut carom(arguments));
        assert!(text.starts_with("carom: ") && text.contains(expected), "{arguments:?}: {text}");
    }
    let folder = refusal(&mut carom(&["run", env!("CARGO_TARGET_TMPDIR")]));
    assert!(folder.contains("directory"), "{folder}");
}

#[test]
fn the_environment_is_checked() {
    for id in ["233", "-1", "many"] {
        let text = refusal(carom(&["--for", "1"]).env("ROS_DOMAIN_ID", id));
        assert!(text.contains(&format!("ROS_DOMAIN_ID={id}: must be 0 to 232")), "{text}");
    }
    let text = refusal(carom(&["--for", "1"]).env("ROS_AUTOMATIC_DISCOVERY_RANGE", "MARS"));
    assert!(text.contains("ROS_AUTOMATIC_DISCOVERY_RANGE=MARS"), "{text}");
}

#[test]
fn help_and_version_go_to_stdout() {
    let help = output(&["--help"]);
    assert!(help.status.success() && help.stderr.is_empty());
    assert!(String::from_utf8_lossy(&help.stdout).contains("run"));
    assert!(output(&["--version"]).status.success());
    // Names in the help are those of the shipped scenes.
    let help = String::from_utf8_lossy(&output(&["run", "--help"]).stdout).into_owned();
    for name in carom::scene::shipped::names() {
        assert!(help.contains(name), "{name}");
    }
}

#[test]
fn a_run_ends_by_itself_and_says_how_it_went() {
    for scene in ["arena", "head_on", "newtons_cradle", "break_shot", "teams"] {
        let output = output(&["run", scene, "--for", "5", "--rate", "0"]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{text}");
        let last = text.lines().last().unwrap_or_default();
        for word in ["t = 5.0 s", "real-time factor", "contacts/s", "energy drift", "overlap"] {
            assert!(last.contains(word), "{scene}: {text}");
        }
    }
}

#[test]
fn every_method_runs_a_scene() {
    for (scene, method) in
        [("arena", "events"), ("teams", "ticks"), ("teams", "steps"), ("head_on", "springs")]
    {
        let has_step = matches!(method, "steps" | "springs");
        let step: &[&str] = if has_step { &["--step", "0.002"] } else { &[] };
        let arguments = ["run", scene, "--for", "3", "--rate", "0", "--method", method];
        let output = output(&[&arguments, step].concat());
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{scene} {method}: {text}");
        let last = text.lines().last().unwrap_or_default();
        assert!(last.contains("t = 3.0 s"), "{text}");
        assert_eq!(last.contains("late"), method == "steps", "{text}");
    }
}

#[test]
fn a_budget_chooses_the_method_and_says_so() {
    let run = |scene, more: &[&str]| {
        let output = output(&[&["run", scene, "--for", "1", "--rate", "0"], more].concat());
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{text}");
        let first = text.lines().next().unwrap_or_default();
        (first.to_owned(), text.lines().last().unwrap_or_default().contains("late"))
    };
    let (first, late) = run("thousand", &["--error", "1e-6", "--budget", "10s"]);
    assert!(first.starts_with("carom: events: error ") && !late, "{first}");
    assert!(first.ends_with("within error 1.0e-6 and budget 10 s"), "{first}");
    let (first, late) = run("head_on", &["--error", "1e-2", "--method", "steps"]);
    assert!(first.starts_with("carom: steps of ") && late, "{first}");
    let (first, _) = run("head_on", &["--error", "1e-30", "--budget", "10s"]);
    assert!(first.contains("the error of 1.0e-30 gives way, by "), "{first}");
}

#[test]
fn real_time_is_kept() {
    let start = Instant::now();
    assert!(output(&["run", "head_on", "--for", "1"]).status.success());
    let twice = start.elapsed();
    assert!(twice >= Duration::from_secs(1), "{twice:?}");
    assert!(output(&["run", "resolver", "--for", "0.5"]).status.success());
}

#[test]
fn a_stalled_arena_ends_with_exit_code_1() {
    let scene = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("squeeze.yaml");
    let text = "walls: {x: [0, 100], y: [0, 4]}\npucks:\n  \
                - {name: light, position: [1, 2], velocity: [1, 0], radius: 0.5}\n  \
                - {name: piston, position: [4.5, 2], velocity: [-1, 0], radius: 0.5, mass: .inf}\n";
    std::fs::write(&scene, text).expect("a scratch folder");
    let output = output(&["run", &scene.to_string_lossy(), "--for", "9", "--rate", "0"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("carom: arena stalled at t = 2.99"), "{text}");
}

#[test]
fn long_times_and_deaf_terminals_are_no_reason_to_panic() {
    let mut child = carom(&["resolver", "--for", "1e300"])
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program was built");
    // The reader of the log goes away at once.
    drop(child.stderr.take());
    std::thread::sleep(Duration::from_millis(300));
    assert!(child.try_wait().expect("our child").is_none(), "it runs on");
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill runs").success());
    assert_eq!(child.wait().expect("our child").code(), Some(0));
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux");
    let status = carom(&["nosuch"]).stderr(full).status().expect("the program was built");
    assert_eq!(status.code(), Some(2));
    let text = refusal(&mut carom(&["--rate", "0", "run", "arena"]));
    assert!(text.contains("cannot be used with: --rate <FACTOR>"), "{text}");
}

/// Ends a running node by a signal; the code it ends with and the time that it takes.
fn end_by(signal: &str) -> (Option<i32>, Duration) {
    let mut child = carom(&[]).stderr(Stdio::piped()).spawn().expect("the program was built");
    let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines();
    assert!(lines.next().expect("a line").expect("text").contains("the default arena"));
    let start = Instant::now();
    let kill = Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(kill.expect("kill runs").success());
    let status = child.wait().expect("our child");
    (status.code(), start.elapsed())
}

#[test]
fn signals_end_it_cleanly() {
    for signal in ["-INT", "-TERM"] {
        let (code, time) = end_by(signal);
        assert_eq!(code, Some(0), "{signal}");
        assert!(time < Duration::from_secs(2), "{signal}: {time:?}");
    }
}
