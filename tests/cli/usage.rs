//! The command line itself: what is taken, what is refused, and with which exit code.

use crate::room::{FIVE, Room, STILL};

#[test]
fn help_opens_with_examples_and_names_the_exit_codes() {
    let room = Room::with(&[]);
    let help = room.good(&["--help"]);
    assert!(help.text().starts_with("Examples:\n"), "{}", help.text());
    for word in ["render", "check", "new", "params", "completions", "man", "143"] {
        assert!(help.text().contains(word), "{word}");
    }
    for command in ["render", "check", "new", "params", "completions", "man"] {
        let help = room.good(&[command, "--help"]);
        assert!(help.text().starts_with("Examples:\n"), "{command}: {}", help.text());
    }
    assert!(room.good(&["--version"]).text().starts_with("reflet "));
}

#[test]
fn words_that_are_not_known_are_usage_errors() {
    let room = Room::furnished();
    let render = |more: &[&str], words: &[&str]| {
        room.bad(&[&["render", "still.rhai", "-o", "a.png"], more].concat(), 2, words);
    };
    room.bad(&["rendr"], 2, &["render"]);
    room.bad(&["render", "still.rhai"], 2, &["--output"]);
    room.bad(&["render", "-o", "a.png"], 2, &["SCRIPT"]);
    render(&["--thread", "1"], &["--threads"]);
    for threads in ["0", "-1", "x", "1025", "99999999999999999999"] {
        render(&[&format!("--threads={threads}")], &["1 to 1024"]);
    }
    render(&["--isa", "avx1024"], &["avx2", "scalar"]);
    render(&["--format", "pgn"], &["png"]);
    render(&["--max-operations", "0"], &["--max-operations"]);
    render(&["--set", "gloss"], &["gloss=0.7"]);
    room.bad(&["render", "still.rhai", "-o", "a.pgn"], 2, &["png"]);
    room.bad(&["render", "still.rhai", "-o", "a"], 2, &["ending"]);
    room.bad(&["render", "still.rhai", "-o", "out/"], 2, &["folder"]);
    room.bad(&["render", "still.rhai", "-o", ""], 2, &["--output"]);
    room.bad(&["render", "still.rhai", "-o", "a-#-#.png"], 2, &["two places"]);
    room.bad(&["render", "still.rhai", "-o", "a-####.gif"], 2, &["all frames"]);
    room.bad(&["man", "nothing"], 2, &["render"]);
    room.bad(&["completions", "cobol"], 2, &["bash"]);
    assert!(room.made().is_empty(), "{:?}", room.made());
}

#[test]
fn words_that_do_not_go_together_are_usage_errors() {
    let room = Room::furnished();
    room.bad(&["render", "still.rhai", "-o", "-", "--json"], 2, &["--json", "-o -"]);
    room.bad(&["render", "still.rhai", "-o", "-", "--watch"], 2, &["--watch"]);
}

#[test]
fn kernels_that_this_machine_lacks_are_a_usage_error() {
    let room = Room::furnished();
    // No machine has both.
    let foreign = if cfg!(target_arch = "x86_64") { "neon" } else { "avx2" };
    let args = ["render", "still.rhai", "-o", "a.png", "--isa", foreign];
    room.bad(&args, 2, &[foreign, "scalar"]);
    assert!(room.made().is_empty());
}

#[test]
fn absurd_sizes() {
    let room = Room::furnished();
    let render =
        |size: &str| ["render", "still.rhai", "-o", "a.png", "--size", size].map(String::from);
    for size in
        ["0", "0x0", "0x5", "5x0", "65536x1", "100000x100000", "-5x5", "5", "axb", "5x", "1e3x5"]
    {
        let args = render(size);
        room.bad(&args.each_ref().map(String::as_str), 2, &["--size"]);
    }
    // Three pictures of 12 GiB and more: no machine that runs this test has so much to spare.
    let args = ["render", "still.rhai", "-o", "a.exr", "--size", "65535x65535"];
    room.bad(&args, 1, &["memory"]);
    let args = ["render", "five.rhai", "-o", "a.gif", "--size", "65535x65535"];
    room.bad(&args, 1, &["memory"]);
    assert!(room.made().is_empty(), "{:?}", room.made());
    for (size, width, height) in [("1x1", 1, 1), ("65535x1", 65535, 1), ("1X300", 1, 300)] {
        room.good(&["render", "still.rhai", "-o", "a.png", "--size", size]);
        let (w, h, _) = crate::room::png(&room.path("a.png"));
        assert_eq!((w, h), (width, height));
    }
}

#[test]
fn frame_ranges() {
    let room = Room::furnished();
    let render = |frames: &str, name: &str| {
        let out = format!("{name}/f-##.png");
        room.run(&["render", "five.rhai", "-o", &out, "--frames", frames])
    };
    for (frames, name, expected) in [
        ("3", "one", vec!["f-03.png"]),
        ("1-3", "some", vec!["f-01.png", "f-02.png", "f-03.png"]),
        ("0-4:2", "steps", vec!["f-00.png", "f-02.png", "f-04.png"]),
        ("4-0:-3", "down", vec!["f-01.png", "f-04.png"]),
        ("4,0-1,1", "list", vec!["f-00.png", "f-01.png", "f-04.png"]),
    ] {
        let ran = render(frames, name);
        assert_eq!(ran.code, Some(0), "{frames}: {}", ran.err);
        assert_eq!(room.names_in(name), expected, "{frames}");
    }
    for frames in ["5", "0-5", "0-4294967295", "3,9-9", "", "1-", "x", "3-1", "0-4:0", "1.5", "-1"]
    {
        let out = ["render", "five.rhai", "-o", "bad/f.png", &format!("--frames={frames}")];
        room.bad(&out, 2, &["--frames"]);
    }
    room.bad(&["render", "still.rhai", "-o", "bad/f.png", "--frames", "1"], 2, &["one frame, 0"]);
    assert!(!room.path("bad").exists());
}

#[test]
fn parameters_are_set_and_listed() {
    let script = format!(
        "{STILL}let gloss = param(\"gloss\", 0.25, 0.0, 1.0);\nlet n = param(\"n\", 3, 1, 9);\n"
    );
    let room = Room::with(&[("p.rhai", &script), ("still.rhai", STILL)]);
    room.good(&["render", "p.rhai", "-o", "a.png", "--set", "gloss=0.5", "--set", "n=9"]);
    for bad in ["gloss=2", "gloss=x", "n=1.5", "glos=0.5", "gloss=nan"] {
        let name = bad.split('=').next().unwrap();
        let words: &[&str] = if name == "glos" { &["glos", "gloss"] } else { &[name] };
        room.bad(&["render", "p.rhai", "-o", "b.png", "--set", bad], 2, words);
    }
    let twice = ["--set", "gloss=0.1", "--set", "n=2", "--set", "gloss=0.2"];
    for command in [&["render", "p.rhai", "-o", "b.png"][..], &["check", "p.rhai"]] {
        room.bad(&[command, &twice].concat(), 2, &["--set gloss", "twice", "0.1", "0.2"]);
    }
    assert_eq!(room.made(), ["a.png"]);
    let json = room.good(&["params", "p.rhai", "--json", "--set", "gloss=0.5"]);
    let rows: serde_json::Value = serde_json::from_str(json.text()).unwrap();
    assert_eq!(rows.as_array().unwrap().len(), 2);
    assert_eq!(rows[0]["name"], "gloss");
    assert_eq!(rows[0]["default"], 0.25);
    assert_eq!(rows[0]["value"], 0.5);
    assert_eq!(rows[1]["whole"], true);
    assert_eq!(rows[1]["high"], 9);
    assert!(room.good(&["params", "p.rhai"]).text().contains("gloss"));
    assert_eq!(room.good(&["params", "still.rhai", "--json"]).text(), "[]\n");
}

#[test]
fn bools_colours_and_choices_are_set_and_listed() {
    let script = format!(
        "{STILL}let shiny = param(\"shiny\", true);\nlet tint = param(\"tint\", [1, 0.5, 0]);\n\
         let finish = param(\"finish\", \"chrome\", [\"chrome\", \"matt\"]);\n"
    );
    let room = Room::with(&[("p.rhai", &script)]);
    let sets = ["--set", "shiny=false", "--set", "tint=#fff", "--set", "finish=matt"];
    let json = room.good(&[&["params", "p.rhai", "--json"][..], &sets].concat());
    let rows: serde_json::Value = serde_json::from_str(json.text()).unwrap();
    let expected = serde_json::json!([
        { "name": "shiny", "kind": "bool", "default": true, "value": false, "line": 7 },
        { "name": "tint", "kind": "colour", "default": [1.0, 0.5, 0.0], "value": [1.0, 1.0, 1.0],
          "line": 8 },
        { "name": "finish", "kind": "choice", "default": "chrome", "choices": ["chrome", "matt"],
          "value": "matt", "line": 9 },
    ]);
    assert_eq!(rows, expected);
    room.good(&["render", "p.rhai", "-o", "a.png", "--set", "tint=0.2,0.4,0.9"]);
    assert!(room.good(&["check", "p.rhai"]).text().contains("finish = chrome"));
    for (bad, words) in [
        ("shiny=1", ["shiny", "true or false"]),
        ("tint=red", ["tint", "#rrggbb"]),
        ("tint=-1,0,0", ["tint", "at least 0"]),
        ("finish=mat", ["\"chrome\", \"matt\"", "did you mean `matt`"]),
    ] {
        room.bad(&["render", "p.rhai", "-o", "b.png", "--set", bad], 2, &words);
    }
    assert_eq!(room.made(), ["a.png"]);
}

#[test]
fn a_wrong_script_is_65_and_a_missing_one_66() {
    let late =
        format!("{STILL}{FIVE}on_frame(|f| {{ if f.index == 3 {{ paint.nonsense = 1; }} }});\n");
    let room = Room::with(&[
        ("syntax.rhai", "camera(#{ eye: "),
        ("key.rhai", "sphere(#{ centre: [0, 0, 0], radius: 1 });"),
        ("late.rhai", &late),
        ("loop.rhai", "loop { }"),
        ("mesh.rhai", &format!("{STILL}mesh(#{{ file: \"no.obj\" }});")),
        ("out.rhai", &format!("{STILL}mesh(#{{ file: \"/etc/passwd\" }});")),
        ("bad.rhai", &format!("{STILL}mesh(#{{ file: \"bad.obj\" }});")),
        ("bad.obj", "v 0 0 0\nv 1 0\n"),
    ]);
    let bad = |script: &str, more: &[&str], code: i32, words: &[&str]| {
        let out = format!("{script}.png");
        room.bad(&[&["render", script, "-o", &out], more].concat(), code, words);
    };
    bad("syntax.rhai", &[], 65, &["syntax.rhai:1:"]);
    bad("key.rhai", &[], 65, &["key.rhai:1:11", "centre", "center"]);
    bad("loop.rhai", &["--max-operations", "10000"], 65, &["loop.rhai:1"]);
    bad("late.rhai", &[], 65, &["nonsense", "frame 3"]);
    assert_eq!(
        room.names_in(".").into_iter().filter(|n| n.contains("png")).collect::<Vec<_>>(),
        ["late.rhai-0000.png", "late.rhai-0001.png", "late.rhai-0002.png"],
        "frames before the wrong one stand"
    );
    bad("mesh.rhai", &[], 66, &["no.obj"]);
    bad("out.rhai", &[], 66, &["absolute"]);
    bad("bad.rhai", &[], 66, &["bad.obj:2"]);
    bad("none.rhai", &[], 66, &["none.rhai"]);
    bad(".", &[], 66, &["."]);
    for command in ["check", "params"] {
        room.bad(&[command, "none.rhai"], 66, &["none.rhai"]);
        room.bad(&[command, "syntax.rhai"], 65, &["syntax.rhai:1:"]);
    }
}

#[test]
fn the_starter_scene_renders_and_is_not_overwritten() {
    let room = Room::with(&[]);
    let made = room.good(&["new", "room"]);
    assert!(made.text().contains("reflet render room.rhai -o room.png"), "{}", made.text());
    let ran = room.good(&["render", "room.rhai", "-o", "room.png"]);
    assert!(!ran.err.contains("warning"), "{}", ran.err);
    let (width, height, pixels) = crate::room::png(&room.path("room.png"));
    assert_eq!((width, height), (640, 360));
    let bright = pixels.iter().filter(|p| **p > 128).count();
    assert!(bright * 10 > pixels.len(), "a lit picture");
    assert!(room.good(&["check", "room.rhai"]).text().contains("no warnings"));

    room.write("room.rhai", "// mine");
    room.bad(&["new", "room"], 74, &["room.rhai is there already"]);
    room.bad(&["new", "room.rhai"], 74, &["room.rhai is there already"]);
    assert_eq!(std::fs::read_to_string(room.path("room.rhai")).unwrap(), "// mine");
    room.good(&["new", "a/b/v1.2"]);
    assert!(room.path("a/b/v1.2.rhai").is_file());
    for bad in ["a/", "..", "/"] {
        room.bad(&["new", bad], 2, &["names no file"]);
    }
    room.bad(&["new", ""], 2, &["NAME"]);
}

/// The animation in the starter scene is commented out: it must run when the slashes go.
#[test]
fn the_starter_scene_has_an_animation_in_comments() {
    let room = Room::with(&[]);
    room.good(&["new", "room"]);
    let text = std::fs::read_to_string(room.path("room.rhai")).unwrap();
    let (still, animation) = text.split_once("// animation(").unwrap();
    let animation = format!("animation({animation}").replace("\n// ", "\n");
    room.write("room.rhai", format!("{still}{animation}"));
    room.good(&["render", "room.rhai", "-o", "a.png", "--frames", "0,24", "--draft"]);
    assert_eq!(room.made(), ["a-0000.png", "a-0024.png"]);
}

#[test]
fn completions_and_manual_pages() {
    let room = Room::with(&[]);
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        assert!(room.good(&["completions", shell]).text().contains("max-operations"), "{shell}");
    }
    assert!(room.good(&["man"]).text().contains(".TH reflet 1"));
    assert!(room.good(&["man", "render"]).text().contains("\\-\\-frames"));
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    let room = Room::furnished();
    let mut child = room
        .command(&["man"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let ran: crate::room::Ran = child.wait_with_output().unwrap().into();
    assert_eq!(ran.code, Some(0));
    assert_eq!(ran.err, "");
}

#[test]
fn files_come_from_the_scripts_folder_and_those_that_are_named() {
    let mesh = "mesh(#{ file: \"m.obj\" });\n";
    let room = Room::with(&[("a.rhai", &format!("{STILL}{mesh}"))]);
    std::fs::create_dir_all(room.path("far/away")).unwrap();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    room.write("far/away/m.obj", triangle);
    room.bad(&["render", "a.rhai", "-o", "a.png"], 66, &["m.obj", "no such file"]);
    room.bad(&["check", "a.rhai", "--assets", "far"], 66, &["m.obj", "nor is it in the 1 other"]);
    room.bad(&["check", "a.rhai", "--assets", "none"], 2, &["--assets", "no such folder"]);
    room.good(&["check", "a.rhai", "--assets", "far", "--assets", "far/away"]);
    room.good(&["render", "a.rhai", "-o", "b.png", "--assets", "far/away"]);
    room.good(&["verify", "a.rhai", "b.png", "--assets", "far/away"]);
    let ran = room.good(&["farm", "commands", "a.rhai", "-o", "c.png", "--assets", "far/away"]);
    assert!(ran.text().contains("--assets far/away"), "{}", ran.text());
    // The script's own folder comes first.
    room.write("m.obj", triangle.replace("1 0 0", "2 0 0"));
    let ran = room.run(&["verify", "a.rhai", "b.png", "--assets", "far/away"]);
    assert_eq!(ran.code, Some(1), "{}", ran.err);
}

#[test]
fn help_is_a_command_too() {
    let room = Room::with(&[]);
    assert_eq!(room.good(&["help"]).text(), room.good(&["--help"]).text());
    for command in [&["render"][..], &["profile"], &["farm"], &["farm", "slurm"]] {
        let help = room.good(&[&["help"], command].concat());
        assert_eq!(help.text(), room.good(&[command, &["--help"]].concat()).text());
    }
    room.bad(&["help", "rendr"], 2, &["rendr"]);
}

#[test]
fn a_number_that_cannot_be_names_its_option_and_what_can() {
    let room = Room::furnished();
    let render = ["render", "five.rhai", "-o", "a.png"];
    let farm = ["farm", "slurm", "five.rhai", "-o", "a.png"];
    let profile = ["profile", "five.rhai"];
    let cases: &[(&[&str], &str, &[&str], &str)] = &[
        (&render, "--threads", &["0", "-1", "x", "", "1025"], "1 to 1024"),
        (&render, "--max-operations", &["0", "-1", "1e9", ""], "from 1 to"),
        (&render, "--cache-mem", &["-1", "x", ""], "512M"),
        (&render, "--size", &["0x0", "", "70000x1"], "65535"),
        (&render, "--shard", &["0/5", "6/5", "1", "-1/5", ""], "2/5"),
        (&render, "--tile", &["0,1/2x2", "3,1/2x2", "1", "-1,1/2x2", ""], "3,2/8x6"),
        (&render, "--frames", &["5", "-1", "", "0-4:0"], "--frames"),
        (&farm, "--chunk", &["0", "-1", "x"], "from 1 to"),
        (&profile, "--repeat", &["0", "-1", "x"], "from 1 to"),
        (&profile, "--frame", &["5", "4294967295"], "--frame: there is no frame"),
        (&profile, "--frame", &["-1", "x", "4294967296"], "from 0"),
        (&profile, "--threads", &["0", "1,0", "-1"], "1 to 1024"),
    ];
    for (command, option, values, allowed) in cases {
        for value in *values {
            room.bad(&[*command, &[option, value]].concat(), 2, &[option, allowed]);
        }
    }
    assert!(room.made().is_empty(), "{:?}", room.made());
}

#[test]
fn what_is_almost_a_frame_number_is_no_name() {
    let room = Room::furnished();
    for out in ["p%4d.png", "p%x.png", "p%%.png", "50%off.png", "%#.png", "%04d/p.png", "##/p.png"]
    {
        for script in ["still.rhai", "five.rhai"] {
            room.bad(&["render", script, "-o", out], 2, &[out, "%04d"]);
        }
        room.bad(&["farm", "commands", "five.rhai", "-o", out], 2, &[out, "%04d"]);
        room.bad(&["verify", "five.rhai", out], 2, &[out, "%04d"]);
    }
    assert!(room.made().is_empty(), "{:?}", room.made());
    room.good(&["render", "still.rhai", "-o", "100%.png"]);
    room.good(&["render", "five.rhai", "-o", "p%02d.png", "--frames", "3"]);
    assert_eq!(room.made(), ["100%.png", "p03.png"]);
}

/// What is printed to be pasted is read by a shell as it is meant.
#[cfg(unix)]
#[test]
fn a_printed_command_can_be_pasted() {
    for name in ["my scene", "it's $HOME `x` \"q\"", "-o", "a#b", "p%4d", "ä;b&c", "=x"] {
        let room = Room::with(&[]);
        let made = room.good(&["new", "--", name]);
        let command = made.text().lines().last().unwrap().trim();
        let mut sh = std::process::Command::new("sh");
        let folder = std::path::Path::new(env!("CARGO_BIN_EXE_reflet")).parent().unwrap();
        let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap_or_default());
        sh.args(["-c", command]).env("PATH", path).current_dir(room.path("."));
        let ran = sh.output().unwrap();
        assert!(ran.status.success(), "{command}: {}", String::from_utf8_lossy(&ran.stderr));
        assert_eq!(room.names_in(".").len(), 2, "{command}: {:?}", room.names_in("."));
    }
}
