//! `--watch`: again at each save, whatever went wrong before.

use crate::room::{Room, STILL};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// Saves a file in one step, so that a busy machine does not show it half written.
fn save(room: &Room, name: &str, text: impl AsRef<[u8]>) {
    room.write("new", text);
    std::fs::rename(room.path("new"), room.path(name)).unwrap();
}

/// A watching render, whose events are read as they come.
struct Watching {
    child: Child,
    events: Receiver<Value>,
}

impl Watching {
    fn start(room: &Room, more: &[&str]) -> Self {
        let args = [&["render", "a.rhai", "-o", "a.png", "--watch", "--json"], more].concat();
        let mut child =
            room.command(&args).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        let (sender, events) = channel();
        std::thread::spawn(move || {
            for line in out.lines().map_while(Result::ok) {
                let _ = sender.send(serde_json::from_str(&line).expect("an event"));
            }
        });
        Self { child, events }
    }

    /// The next event that ends a render.
    fn ended(&self) -> Value {
        loop {
            // The machine may be busy; a render of 16 x 9 pixels takes no second.
            let event = self.events.recv_timeout(Duration::from_secs(60)).expect("a render ends");
            if event["event"] == "done" || event["event"] == "error" {
                return event;
            }
        }
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn each_save_renders_and_errors_are_survived() {
    let room = Room::with(&[("a.rhai", STILL)]);
    let watching = Watching::start(&room, &[]);
    assert_eq!(watching.ended()["event"], "done");
    let first = std::fs::read(room.path("a.png")).unwrap();

    save(&room, "a.rhai", "nonsense(");
    assert_eq!(watching.ended()["exit"], 65);
    assert_eq!(std::fs::read(room.path("a.png")).unwrap(), first, "the picture stays");

    std::fs::remove_file(room.path("a.rhai")).unwrap();
    assert_eq!(watching.ended()["exit"], 66);

    save(&room, "a.rhai", STILL.replace("0.8, 0.4, 0.2", "0.2, 0.4, 0.8"));
    assert_eq!(watching.ended()["event"], "done");
    assert_ne!(std::fs::read(room.path("a.png")).unwrap(), first);

    save(&room, "a.rhai", STILL);
    assert_eq!(watching.ended()["event"], "done");
    assert_eq!(std::fs::read(room.path("a.png")).unwrap(), first);
}

#[test]
fn a_save_of_a_mesh_renders_too() {
    let script = format!("{STILL}mesh(#{{ file: \"m.obj\", translate: [-0.5, 0, 2] }});");
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let room = Room::with(&[("a.rhai", &script), ("m.obj", obj)]);
    let watching = Watching::start(&room, &["--draft", "--size", "64x36"]);
    assert_eq!(watching.ended()["event"], "done");
    let first = std::fs::read(room.path("a.png")).unwrap();
    save(&room, "m.obj", "v broken\n");
    assert_eq!(watching.ended()["exit"], 66);
    save(&room, "m.obj", obj.replace("1 0 0", "2 0 0"));
    assert_eq!(watching.ended()["event"], "done");
    assert_ne!(std::fs::read(room.path("a.png")).unwrap(), first);
}

#[test]
fn a_script_that_is_not_there_at_the_start_is_not_waited_for() {
    let room = Room::with(&[]);
    room.bad(&["render", "a.rhai", "-o", "a.png", "--watch"], 66, &["a.rhai"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_is_how_watching_ends_and_no_error() {
    let room = Room::with(&[("a.rhai", STILL)]);
    let args = ["render", "a.rhai", "-o", "a.png", "--watch", "--json"];
    let mut child =
        room.command(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut events = BufReader::new(child.stdout.take().unwrap()).lines();
    while !events.next().unwrap().unwrap().contains("\"done\"") {}
    // The line is printed before files are waited for.
    std::thread::sleep(Duration::from_millis(500));
    let pid = child.id().to_string();
    std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap();
    let ran: crate::room::Ran = child.wait_with_output().unwrap().into();
    assert_eq!(ran.code, Some(130), "{}", ran.err);
    assert!(!ran.err.contains("error") && ran.err.ends_with("no longer watching\n"), "{}", ran.err);
}
