//! `reflet farm`: what it writes, run by the schedulers themselves; the farmed frames are the local
//! ones, byte for byte.
//!
//! A scheduler that is not there is skipped with a message; with `REFLET_REQUIRE_TOOLS=1` in the
//! environment, as in CI, it is a failure.
#![cfg(unix)]

use crate::room::{FIVE, Room, STILL};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

const OUT: &str = "farmed/f-##.png";

fn room() -> Room {
    let room = Room::furnished();
    // Slow enough to be stopped in between.
    let slow = "on_frame(|f| { let x = 0; for i in 0..100000 { x += i; } });";
    let more = FIVE.replace("frames: 5", "frames: 12");
    room.write("slow.rhai", format!("{STILL}{more}{slow}"));
    room.good(&["render", "slow.rhai", "-o", "local/f-##.png"]);
    room.good(&["render", "still.rhai", "-o", "local.png", "--size", "70x50"]);
    room.good(&["film", "local/f-##.png", "-o", "local.webp", "--fps", "10"]);
    room
}

/// Whether a program can be started with these words.
pub fn works(program: &str, words: &[&str]) -> bool {
    let mut command = Command::new(program);
    command.args(words).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

fn skip(what: &str) {
    let required = std::env::var_os("REFLET_REQUIRE_TOOLS").is_some_and(|v| v == "1");
    assert!(!required, "{what}, and REFLET_REQUIRE_TOOLS=1 asks for it");
    println!("skipped: {what}");
}

/// A scheduler that is there and that this machine does not let run: no failure of ours, but CI's
/// last line tells of it.
fn cannot_run(why: &str) {
    let Some(report) = std::env::var_os("REFLET_REPORT") else { return skip(why) };
    let report = std::fs::File::options().append(true).create(true).open(report);
    writeln!(report.unwrap(), "not run: {why}").unwrap();
}

fn same(room: &Room, one: &str, other: &str) {
    let read =
        |name: &str| std::fs::read(room.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert!(read(one) == read(other), "{one} and {other} differ");
}

fn same_frames(room: &Room) {
    assert_eq!(room.names_in("farmed"), room.names_in("local"));
    for name in room.names_in("local") {
        same(room, &format!("farmed/{name}"), &format!("local/{name}"));
    }
}

fn written(room: &Room, name: &str, words: &[&str]) -> PathBuf {
    let ran = room.good(words);
    room.write(name, ran.out);
    room.path(name)
}

pub fn shown(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    format!("{}\n{}\n{}", output.status, text(&output.stdout), text(&output.stderr))
}

/// A path in which `reflet` is the binary under test.
pub fn path() -> String {
    let folder = Path::new(env!("CARGO_BIN_EXE_reflet")).parent().unwrap();
    format!("{}:{}", folder.display(), std::env::var("PATH").unwrap_or_default())
}

/// The commands of README.md that begin with `reflet farm` and this word, as they stand there.
fn told_by_readme(scheduler: &str) -> Vec<String> {
    let text = include_str!("../../README.md");
    let first = format!("reflet farm {scheduler} ");
    let lines = text.lines().skip_while(|line| !line.starts_with(&first));
    let lines: Vec<String> = lines.take_while(|line| *line != "```").map(str::to_owned).collect();
    assert_eq!(lines.len(), 2, "README.md has no two lines for {scheduler}");
    lines
}

/// The scene of README.md, and its frames and film as they are made here.
fn readme_room() -> Room {
    let room = Room::with(&[("room.rhai", &format!("{STILL}{FIVE}"))]);
    room.good(&["render", "room.rhai", "-o", "local/frame-####.png"]);
    room.good(&["film", "local/frame-####.png", "-o", "local.mp4", "--fps", "10"]);
    room
}

fn same_as_local(room: &Room) {
    assert_eq!(room.names_in("out"), room.names_in("local"));
    for name in room.names_in("local") {
        same(room, &format!("out/{name}"), &format!("local/{name}"));
    }
}

/// Runs a line of a shell.
fn shell(room: &Room, line: &str) {
    let mut sh = Command::new("sh");
    let ran = sh.args(["-c", line]).env("PATH", path()).current_dir(room.path(".")).output();
    let ran = ran.unwrap();
    assert!(ran.status.success(), "{line}: {}", shown(&ran));
}

#[test]
fn one_command_a_line() {
    let room = room();
    let words = ["farm", "commands", "slow.rhai", "-o", OUT, "--chunk", "5", "--film", "f.webp"];
    let ran = room.good(&words);
    assert_eq!(
        ran.text(),
        "reflet render slow.rhai -o 'farmed/f-##.png' --resume --frames 0-4\n\
         reflet render slow.rhai -o 'farmed/f-##.png' --resume --frames 5-9\n\
         reflet render slow.rhai -o 'farmed/f-##.png' --resume --frames 10-11\n"
    );
    let end = "when all are done: reflet film 'farmed/f-##.png' -o f.webp --fps 10 --frames 0-11";
    assert_eq!(ran.err.trim_end(), end);
    room.write("tasks.txt", &ran.out);

    // Debian's moreutils has another program of this name.
    if !works("parallel", &["--version"]) {
        return skip("GNU parallel is not there");
    }
    let mut parallel = Command::new("parallel");
    parallel.args(["--joblog", "log", "--resume", "-a", "tasks.txt"]);
    let ran = parallel.env("PATH", path()).current_dir(room.path(".")).output().unwrap();
    assert!(ran.status.success(), "{}", shown(&ran));
    same_frames(&room);

    if works("ffmpeg", &["-version"]) {
        let room = readme_room();
        told_by_readme("commands").iter().for_each(|line| shell(&room, line));
        same_as_local(&room);
    }
}

#[test]
fn mistakes_are_known_before_anything_is_submitted() {
    let room = Room::furnished();
    let farm = |more: &[&str], code: i32, words: &[&str]| {
        room.bad(&[&["farm", "slurm"], more].concat(), code, words);
    };
    farm(&["none.rhai", "-o", "a.png"], 66, &["none.rhai"]);
    farm(&["five.rhai", "-o", "a.gif"], 2, &["--film"]);
    farm(&["five.rhai", "-o", "-"], 2, &["--film"]);
    farm(&["-", "-o", "a.png"], 2, &["file"]);
    farm(&["still.rhai", "-o", "a.png", "--tiles", "1000x1000"], 2, &["--tiles"]);
    farm(&["five.rhai", "-o", "a.png", "--frames", "5"], 2, &["--frames"]);
    farm(&["five.rhai", "-o", "a.png", "--tiles", "2x2"], 2, &["--tiles", "5 frames"]);
    farm(&["five.rhai", "-o", "a.png", "--tiles", "2"], 2, &["8x6"]);
    farm(&["five.rhai", "-o", "a.png", "--film", "a.png"], 2, &["--film"]);
    farm(&["five.rhai", "-o", "a.png", "--set", "x=1"], 2, &["x"]);
}

#[test]
fn open_job_description() {
    let room = room();
    let words = ["farm", "openjd", "slow.rhai", "-o", OUT, "--chunk", "5", "--film", "film.webp"];
    let frames = written(&room, "frames.json", &words);
    let words =
        ["farm", "openjd", "still.rhai", "-o", "farmed.png", "--tiles", "3x2", "--size", "70x50"];
    let tiles = written(&room, "tiles.json", &words);
    if !works("openjd", &["--version"]) {
        return skip("openjd-cli is not there");
    }
    for (template, step) in [(&frames, "Film"), (&tiles, "Merge")] {
        let mut openjd = Command::new("openjd");
        openjd.arg("run").arg(template).args(["--step", step, "--run-dependencies"]);
        let ran = openjd.env("PATH", path()).current_dir(room.path(".")).output().unwrap();
        assert!(ran.status.success(), "{}", shown(&ran));
        for line in ["openjd_progress: 100.0", "frames are done"] {
            assert!(shown(&ran).contains(line), "{}", shown(&ran));
        }
    }
    same_frames(&room);
    same(&room, "film.webp", "local.webp");
    same(&room, "farmed.png", "local.png");

    if !works("ffmpeg", &["-version"]) {
        return skip("ffmpeg is not there");
    }
    // The scene's files may come from another folder than the scene.
    let far = Room::with(&[("far.rhai", &format!("{STILL}mesh(#{{ file: \"m.obj\" }});"))]);
    std::fs::create_dir(far.path("lib")).unwrap();
    far.write("lib/m.obj", "v 0 0 2\nv 1 0 2\nv 0 1 2\nf 1 2 3\n");
    far.good(&["render", "far.rhai", "-o", "local.png", "--assets", "lib"]);
    let words = ["farm", "openjd", "far.rhai", "-o", "farmed-#.png", "--assets", "lib"];
    written(&far, "far.json", &words);
    shell(&far, "openjd run far.json --step Render");
    same(&far, "farmed-0.png", "local.png");

    let room = readme_room();
    told_by_readme("openjd").iter().for_each(|line| shell(&room, line));
    same_as_local(&room);
    same(&room, "room.mp4", "local.mp4");
}

#[test]
fn an_array_fits_into_slurm() {
    let long = format!("{STILL}{}", FIVE.replace("frames: 5", "frames: 20000"));
    let room = Room::with(&[("a.rhai", &long), ("still.rhai", STILL)]);
    let tasks = |more: &[&str]| {
        let ran = room.good(&[&["farm", "slurm", "a.rhai", "-o", "f-#.png"], more].concat());
        let array = ran.text().lines().find_map(|l| l.strip_prefix("#SBATCH --array=1-")).unwrap();
        (array.parse::<u32>().unwrap(), ran.err)
    };
    assert_eq!(tasks(&[]), (1000, String::new()));
    assert_eq!(tasks(&["--frames", "0-999"]), (100, String::new()));
    assert_eq!(tasks(&["--chunk", "20"]), (1000, String::new()));
    let (many, warning) = tasks(&["--chunk", "10"]);
    assert!(many == 2000 && warning.contains("MaxArraySize"), "{warning}");
    let ran = room.good(&["farm", "slurm", "still.rhai", "-o", "a.png", "--tiles", "40x40"]);
    assert!(ran.err.contains("MaxArraySize"), "{}", ran.err);
}

/// A Slurm of one node, ended with the test.
struct Slurm {
    folder: tempfile::TempDir,
}

impl Slurm {
    /// Starts the daemons.
    fn start() -> Result<Slurm, String> {
        let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
        let slurm = Slurm { folder };
        let at = |name: &str| slurm.folder.path().join(name).display().to_string();
        let output = |program: &str, words: &[&str]| {
            let ran = Command::new(program).args(words).output();
            ran.map_or(String::new(), |o| String::from_utf8_lossy(&o.stdout).trim().to_owned())
        };
        let (host, user) = (output("hostname", &["-s"]), output("id", &["-un"]));
        let port = |n: u32| 20_000 + (std::process::id() * 2 + n) % 30_000;
        let conf = format!(
            "ClusterName=reflet\nSlurmctldHost={host}(127.0.0.1)\nSlurmctldPort={}\nSlurmdPort={}\n\
             AuthType=auth/munge\nCryptoType=crypto/munge\nAuthInfo=socket={}\nSlurmUser={user}\n\
             SlurmdUser={user}\nStateSaveLocation={}\nSlurmdSpoolDir={}\nSlurmctldPidFile={}\n\
             SlurmdPidFile={}\nSlurmctldLogFile={}\nSlurmdLogFile={}\nProctrackType=proctrack/pgid\n\
             TaskPlugin=task/none\nSwitchType=switch/none\nMpiDefault=none\nRequeueExit=75\n\
             SelectType=select/cons_tres\nSelectTypeParameters=CR_Core\nReturnToService=2\n\
             NodeName={host} NodeAddr=127.0.0.1 CPUs=1 State=UNKNOWN\n\
             PartitionName=all Nodes={host} Default=YES State=UP OverSubscribe=FORCE:4\n\
             PartitionName=night Nodes={host} State=UP OverSubscribe=FORCE:4\n",
            port(0),
            port(1),
            at("munge"),
            at("state"),
            at("spool"),
            at("slurmctld.pid"),
            at("slurmd.pid"),
            at("slurmctld.log"),
            at("slurmd.log"),
        );
        std::fs::write(at("slurm.conf"), conf).map_err(|e| e.to_string())?;
        for folder in ["state", "spool"] {
            std::fs::create_dir(at(folder)).map_err(|e| e.to_string())?;
        }
        let run = |program: &str, words: &[&str]| {
            let mut command = Command::new(program);
            command.args(words).env("SLURM_CONF", at("slurm.conf")).env("PATH", path());
            // Daemons must not hold the pipes that a test's output is read from.
            command.stdin(Stdio::null()).stdout(Stdio::null());
            let log = std::fs::File::create(at("start.log")).map_err(|e| e.to_string())?;
            let done = command.stderr(log).status().is_ok_and(|status| status.success());
            let told = || std::fs::read_to_string(at("start.log")).unwrap_or_default();
            if done { Ok(()) } else { Err(format!("{program} does not start: {}", told())) }
        };
        let key = format!("head -c 1024 /dev/urandom > '{}' && chmod 400 '{0}'", at("key"));
        run("sh", &["-c", &key])?;
        let (socket, key, pid) = (at("munge"), at("key"), at("munged.pid"));
        let (log, seed) = (at("munged.log"), at("seed"));
        run(
            "munged",
            &[
                "--force",
                &format!("--socket={socket}"),
                &format!("--key-file={key}"),
                &format!("--pid-file={pid}"),
                &format!("--log-file={log}"),
                &format!("--seed-file={seed}"),
            ],
        )?;
        run("slurmctld", &["-c"])?;
        run("slurmd", &[])?;
        let begin = Instant::now();
        while !slurm.run("sinfo", &["-h", "-o", "%T"]).contains("idle") {
            if begin.elapsed() > Duration::from_secs(30) {
                return Err("the node of slurm does not come up".into());
            }
            std::thread::sleep(Duration::from_millis(200));
        }
        Ok(slurm)
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("SLURM_CONF", self.folder.path().join("slurm.conf")).env("PATH", path());
        command.stdin(Stdio::null());
        command
    }

    fn run(&self, program: &str, words: &[&str]) -> String {
        let ran = self.command(program).args(words).output().unwrap();
        String::from_utf8_lossy(&ran.stdout).into_owned()
    }

    /// Submits a script that `reflet farm` wrote, and waits until its jobs are gone.
    fn submit(&self, room: &Room, script: &Path, reflet: &str) {
        let mut sh = self.command("sh");
        self.submitted(room, sh.arg(script).env("REFLET", reflet));
    }

    /// Runs what submits jobs, and waits until they are gone.
    fn submitted(&self, room: &Room, submits: &mut Command) {
        let ran = submits.current_dir(room.path(".")).output().unwrap();
        assert!(ran.status.success(), "{}", shown(&ran));
        let begin = Instant::now();
        loop {
            let queue = self.run("squeue", &["-h", "-r", "-o", "%i %r"]);
            if queue.trim().is_empty() {
                return;
            }
            assert!(begin.elapsed() < Duration::from_secs(120), "{queue}\n{}", logs(room));
            // Slurm lets a requeued task wait for two minutes.
            for task in queue.lines().filter_map(|line| line.strip_suffix(" BeginTime")) {
                self.run("scontrol", &["update", &format!("JobId={task}"), "StartTime=now"]);
            }
            std::thread::sleep(Duration::from_millis(300));
        }
    }
}

impl Drop for Slurm {
    fn drop(&mut self) {
        for name in ["slurmctld", "slurmd", "munged"] {
            let file = self.folder.path().join(format!("{name}.pid"));
            if let Ok(pid) = std::fs::read_to_string(file) {
                let _ = Command::new("kill").arg(pid.trim()).status();
            }
        }
    }
}

/// What the tasks told.
fn logs(room: &Room) -> String {
    let names = room.made().into_iter().filter(|name| name.starts_with("slurm-"));
    names
        .map(|name| {
            let text = std::fs::read_to_string(room.path(&name)).unwrap_or_default();
            format!("{name}:\n{text}\n")
        })
        .collect()
}

#[test]
fn slurm_runs_arrays_and_what_depends_on_them() {
    let room = room();
    let words = ["farm", "slurm", "slow.rhai", "-o", OUT, "--chunk", "5", "--film", "film.webp"];
    let frames = written(&room, "frames.sh", &words);
    let words =
        ["farm", "slurm", "still.rhai", "-o", "farmed.png", "--tiles", "3x2", "--size", "70x50"];
    let tiles = written(&room, "tiles.sh", &words);
    // Most of its programs do not start without a configuration.
    let there = |tool: &str| works("sh", &["-c", &format!("command -v {tool}")]);
    if !["sbatch", "slurmctld", "slurmd", "munged"].into_iter().all(there) {
        return skip("slurm is not there");
    }
    let slurm = match Slurm::start() {
        Ok(slurm) => slurm,
        Err(why) => return cannot_run(&why),
    };
    let reflet = env!("CARGO_BIN_EXE_reflet");
    slurm.submit(&room, &tiles, reflet);
    assert!(room.path("farmed.png").exists(), "{}", logs(&room));
    same(&room, "farmed.png", "local.png");

    // The first task is warned while it renders, and requeued.
    let warned = "#!/bin/sh\n\
        case \"$1 $SLURM_ARRAY_TASK_ID ${SLURM_RESTART_COUNT:-0}\" in\n\
        'render 1 0')\n\
            REFLET \"$@\" &\n\
            while ! ls farmed/f-0[0-3].png >/dev/null 2>&1; do sleep 0.02; done\n\
            kill -USR1 $!\n\
            wait $!;;\n\
        *) exec REFLET \"$@\";;\n\
        esac\n";
    room.write("warned.sh", warned.replace("REFLET", reflet));
    let warned = room.path("warned.sh");
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(&warned, std::fs::Permissions::from_mode(0o755)).unwrap();
    slurm.submit(&room, &frames, &warned.display().to_string());
    let told = logs(&room);
    assert!(told.contains("error: stopped"), "{told}");
    assert!(told.contains("all frames are up to date"), "{told}");
    assert!(room.path("film.webp").exists(), "{told}");
    same_frames(&room);
    same(&room, "film.webp", "local.webp");

    if !works("ffmpeg", &["-version"]) {
        return skip("ffmpeg is not there");
    }
    let room = readme_room();
    for line in told_by_readme("slurm") {
        slurm.submitted(&room, slurm.command("sh").args(["-c", &line]));
    }
    same_as_local(&room);
    same(&room, "room.mp4", "local.mp4");
}
