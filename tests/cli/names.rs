//! Names are data: what `reflet farm` writes runs nothing that a name says, and finds what has it.
#![cfg(unix)]

use crate::farmed::{path, shown, works};
use crate::room::{FIVE, Room, STILL};
use std::process::{Command, Output, Stdio};

/// Names made to break out of whatever quotes them.
const NAMES: [&str; 8] = [
    "it's; touch owned; '",
    "$(touch owned) `touch owned` ${HOME}",
    "a -o PART b@c \"d\" \\",
    "{{Param.Reflet}} {{x",
    "-rf",
    "!h *?[a] ~ & | < > (x)",
    "ünï 日本",
    "%j %A {} {1}",
];

/// A stand-in for Slurm's `sbatch`, which runs the job at once, each task of its array.
const SBATCH: &str = r#"#!/bin/sh
job=$(mktemp)
cat > "$job"
last=$(sed -n 's/^#SBATCH --array=1-//p' "$job")
task=1
while [ "$task" -le "${last:-1}" ]; do
    SLURM_ARRAY_TASK_ID=$task sh "$job" >&2 || exit
    task=$((task + 1))
done
rm "$job"
echo "7;cluster"
"#;

/// A room in which the scenes and folders have such a name.
fn odd_room(name: &str) -> Room {
    use std::os::unix::fs::PermissionsExt;
    let scene = format!("{STILL}{FIVE}let label = param(\"x\", 1.0, 0.0, 2.0);");
    let room = Room::with(&[]);
    std::fs::create_dir(room.path(name)).unwrap();
    room.write(&format!("{name}/{name}.rhai"), &scene);
    room.write(&format!("{name}.rhai"), &scene);
    std::fs::create_dir(room.path("bin")).unwrap();
    room.write("bin/sbatch", SBATCH);
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(room.path("bin/sbatch"), executable).unwrap();
    room
}

/// Runs a shell in which `sbatch` is the stand-in.
fn odd_shell(room: &Room, words: &[&str]) {
    let path = format!("{}:{}", room.path("bin").display(), path());
    let mut sh = Command::new("sh");
    let ran = ran_of(sh.args(words).env("PATH", path).current_dir(room.path(".")));
    assert!(ran.status.success(), "{words:?}: {}", shown(&ran));
    assert!(!room.path("owned").exists(), "{words:?}");
}

fn ran_of(command: &mut Command) -> Output {
    command.stdin(Stdio::null()).output().unwrap()
}

#[test]
fn jobs_take_names_as_data() {
    for name in NAMES {
        let room = odd_room(name);
        let (script, inner) = (format!("{name}.rhai"), format!("{name}/{name}.rhai"));
        // In the name of an output a % before a letter is refused.
        let made = name.replace('%', "");
        let out = |folder: &str| format!("--output={name}/{folder}/{made}-#.png");
        let frames = format!("{name}/f/{made}-4.png");
        let (assets, film) = (format!("--assets={name}"), format!("--film={made}.webp"));
        let farm = |kind: &str, more: &[&str]| {
            let words = ["farm", kind, "--chunk", "2", "--set", "x=1.5", &assets];
            room.good(&[&words[..], more].concat())
        };
        let job = farm("slurm", &[&out("f"), &film, "--", &script]);
        room.write("job.sh", &job.out);
        odd_shell(&room, &["job.sh"]);
        assert!(room.path(&frames).is_file(), "{name}: {:?}", room.names_in("."));
        assert!(room.path(&format!("{made}.webp")).is_file(), "{name}");

        let whole = format!("--output={made}.png");
        let tiles = ["--tiles", "2x1", "--frames", "3", &whole, "--", &inner];
        room.write("job.sh", farm("slurm", &tiles).out);
        odd_shell(&room, &["job.sh"]);
        assert!(room.path(&format!("{made}.png")).is_file(), "{name}");

        let tasks = farm("commands", &[&out("g"), "--", &inner]);
        room.write("tasks.sh", &tasks.out);
        odd_shell(&room, &["tasks.sh"]);
        assert!(room.path(&frames.replace("/f/", "/g/")).is_file(), "{name}");

        let template = farm("openjd", &[&out("h"), &film, "--", &inner]);
        room.write("job.json", &template.out);
        let words = openjd_words(&serde_json::from_slice(&template.out).unwrap(), "Render");
        assert_eq!(words[1], format!("{}/{name}.rhai", safe(name)), "{words:?}");
        assert_eq!(words[3], format!("{}/h/{made}-#.png", safe(name)));
        // What an engine does with braces is its own; the rest is the same to it.
        if name.contains('{') && works("openjd", &["--version"]) {
            let mut openjd = Command::new("openjd");
            openjd.args(["run", "job.json", "--step", "Film", "--run-dependencies"]);
            let ran = ran_of(openjd.env("PATH", path()).current_dir(room.path(".")));
            assert!(ran.status.success(), "{name}: {}", shown(&ran));
            assert!(room.path(&frames.replace("/f/", "/h/")).is_file(), "{name}");
        }
        assert!(!room.path("owned").exists(), "{name}");
    }
}

/// A path that no option begins like.
fn safe(name: &str) -> String {
    if name.starts_with('-') { format!("./{name}") } else { name.into() }
}

/// The arguments of a step's command, with each parameter in them replaced once by its default, as
/// an engine does it.
fn openjd_words(template: &serde_json::Value, step: &str) -> Vec<String> {
    let default = |name: &str| {
        let mut all = template["parameterDefinitions"].as_array().unwrap().iter();
        all.find(|p| p["name"] == name).map(|p| p["default"].as_str().unwrap().to_owned())
    };
    let mut steps = template["steps"].as_array().unwrap().iter();
    let step = steps.find(|s| s["name"] == step).unwrap();
    let words = step["script"]["actions"]["onRun"]["args"].as_array().unwrap();
    let resolved = |word: &serde_json::Value| {
        let (mut text, mut rest) = (String::new(), word.as_str().unwrap());
        while let Some((before, after)) = rest.split_once("{{") {
            let (name, after) = after.split_once("}}").unwrap();
            text += before;
            match name.strip_prefix("Param.").and_then(default) {
                Some(value) => text += &value,
                None => text += name,
            }
            rest = after;
        }
        text + rest
    };
    words.iter().map(resolved).collect()
}

#[test]
fn what_no_job_can_hold_is_refused() {
    use std::ffi::OsString;
    use std::os::unix::ffi::OsStringExt;
    let evil = "a\nJOB\n)\ntouch owned\n";
    let odd = |bytes: &[u8]| OsString::from_vec(bytes.to_vec());
    let room = Room::furnished();
    let scene = std::fs::read(room.path("five.rhai")).unwrap();
    let mut scripts = vec![odd(format!("{evil}.rhai").as_bytes()), odd(b"a\x1b[2J.rhai")];
    scripts.extend([odd(b"tab\t.rhai"), odd("del\u{7f}.rhai".as_bytes())]);
    scripts.extend([odd("\u{85}.rhai".as_bytes()), odd(b"\xff.rhai")]);
    let bad = |words: &[OsString], option: &str| {
        let ran: crate::room::Ran = room.command(words).output().unwrap().into();
        assert_eq!(ran.code, Some(2), "{words:?}: {}", ran.err);
        assert!(ran.err.contains(option) && ran.out.is_empty(), "{words:?}: {}", ran.err);
        assert!(!ran.err.contains(['\u{1b}', '\t']), "{}", ran.err);
    };
    for kind in ["slurm", "commands", "openjd"] {
        for script in &scripts {
            if std::fs::write(room.path(".").join(script), &scene).is_ok() {
                bad(&["farm".into(), kind.into(), script.clone(), "-oa-#.png".into()], "SCRIPT");
            }
        }
        let five = ["farm".into(), kind.into(), "five.rhai".into(), "-oa-#.png".into()];
        let with = |word: String| [&five[..], &[word.into()]].concat();
        bad(&with(format!("--film={evil}.mp4")), "--film");
        bad(&with(format!("--set=a=b{evil}c")), "--set");
        let out = format!("-o{evil}-#.png").into();
        bad(&["farm".into(), kind.into(), "five.rhai".into(), out], "--output");
    }
}
