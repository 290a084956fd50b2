//! `reflet check`.

use crate::room::{FIVE, Room, STILL};

#[test]
fn a_good_scene_is_described() {
    let script = format!(
        "{STILL}{FIVE}plane(#{{ point: [0, -1.5, 0], normal: [0, 1, 0], material: #{{ specular: 0.5 }} }});\nlet gloss = param(\"gloss\", 0.25, 0.0, 1.0);\n"
    );
    let room = Room::with(&[("a.rhai", &script)]);
    let ran = room.good(&["check", "a.rhai", "--set", "gloss=0.5"]);
    assert_eq!(ran.err, "");
    for line in [
        "a.rhai",
        "picture     16x9, 1 sample a pixel",
        "frames      5, 10 a second (0.5 s)",
        "camera      at [0, 0, 5], looking at [0, 0, 0], 45 degrees high",
        "surfaces    1 sphere, 1 plane",
        "bounds      [-1, -1, -1] to [1, 1, 1], planes without end",
        "lights      1 point light",
        "materials   2 materials, 1 of them mirroring",
        "parameter   gloss = 0.5, 0 to 1",
        "no warnings",
    ] {
        assert!(ran.text().lines().any(|l| l == line), "no {line:?} in:\n{}", ran.text());
    }
    assert!(ran.text().contains("memory      about "), "{}", ran.text());
    assert_eq!(room.made(), [""; 0]);
}

#[test]
fn what_looks_wrong_is_told_and_is_no_failure() {
    let room = Room::with(&[]);
    let cases: &[(&str, &str)] = &[
        (
            "sphere(#{ center: [0, 0, 0], radius: 1 });",
            "sphere 1 (center [0, 0, 0], radius 1) and sphere 2 (center [0, 0, 0], radius 1) coincide",
        ),
        (
            "plane(#{ point: [0, -3, 0], normal: [0, 1, 0] }); plane(#{ point: [5, -3, 2], normal: [0, -2, 0] });",
            "plane 1 (through [0, -3, 0]) and plane 2 (through [5, -3, 2]) coincide",
        ),
        (
            "quad(#{ corner: [2, 0, 0], u: [1, 0, 0], v: [0, 1, 0] }); triangle(#{ a: [2, 0, 0], b: [9, 0, 0], c: [2, 9, 0] });",
            "quad 1 (corner [2, 0, 0]) and triangle 1 (a [2, 0, 0]) overlap in one plane",
        ),
        (
            "light(#{ at: [0, 1, 0], emissivity: 1 });",
            "the light at [0, 1, 0] lies on sphere 1 (center [0, 0, 0], radius 1)",
        ),
        (
            "sphere(#{ center: [0, 0, 6], radius: 1.5, material: #{ ambient: 1 } });",
            "the camera at [0, 0, 5] is inside sphere 2 (center [0, 0, 6], radius 1.5)",
        ),
        (
            "light(#{ at: [3, 0, 0], emissivity: 9 });\ncuboid(#{ min: [2, -1, -1], max: [4, 1, 1] });",
            "light (line 7) is inside cuboid (line 8), and its light reaches nothing outside",
        ),
        (
            "sphere(#{ center: [0, 0, 0], radius: 900, material: #{ ambient: 500 } });\nsun(#{ direction: [0, -1, 0], emissivity: 1 });",
            "sun (line 8) is outside sphere (line 7, no. 2), which the camera is in, and its light reaches nothing inside",
        ),
        (
            "sphere(#{ center: [2, 0, 0], radius: 1, material: #{ diffuse: [200, 30, 30] } });",
            "material (line 7, no. 1): diffuse [200, 30, 30] looks like 0..255, and 1 is full: divide by 255, or write srgb(\"#rrggbb\")",
        ),
        (
            "settings(#{ background: [135, 206, 235] });",
            "settings (line 7): background [135, 206, 235] looks like 0..255, and 1 is full: divide by 255, or write srgb(\"#rrggbb\")",
        ),
        (
            "light(#{ at: [3, 0, 3], emissivity: 0 });",
            "light (line 7) has emissivity 0 and lights nothing",
        ),
        (
            "sphere(#{ center: [2, 0, 0], radius: 1, material: #{} });",
            "material (line 7, no. 1) is all 0, so that what wears it is black",
        ),
        (
            "on_frame(|f| { paint.diffuse = 1 - f.t; });",
            "there is an on_frame and no animation, so the scene is a still; write animation(#{ frames: 120, fps: 24 })",
        ),
        (
            "animation(#{ frames: 9 });",
            "the animation has 9 frames and no on_frame, so they are all the same picture; write on_frame(|f| { ... }), or leave animation out",
        ),
        (
            "animation(#{ frames: 99 }); on_frame(|f| { let x = f.t; });",
            "on_frame changes nothing: all 99 frames are the same picture",
        ),
    ];
    for (more, warning) in cases {
        room.write("a.rhai", format!("{STILL}{more}\n"));
        let ran = room.good(&["check", "a.rhai"]);
        assert_eq!(ran.err, format!("warning: {warning}\n"), "{more}");
        assert!(ran.text().ends_with("1 warning\n"), "{}", ran.text());
    }
    room.write("a.rhai", STILL.replace("light(", "// light("));
    let ran = room.good(&["check", "a.rhai"]);
    assert!(ran.err.contains("light"), "{}", ran.err);
}

#[test]
fn the_last_frame_is_looked_at_too() {
    let meet = "let b = sphere(#{ center: [3, 0, 0], radius: 1 });
animation(#{ frames: 5 });
on_frame(|f| { b.center = [3 * (1 - f.t), 0, 0]; });";
    let fail = "animation(#{ frames: 5 }); on_frame(|f| { if f.index == 4 { paint.x = 1; } });";
    let room = Room::with(&[
        ("meet.rhai", &format!("{STILL}{meet}")),
        ("fail.rhai", &format!("{STILL}{fail}")),
    ]);
    let ran = room.good(&["check", "meet.rhai"]);
    assert!(ran.err.ends_with("coincide (in frame 4)\n"), "{}", ran.err);
    room.bad(&["check", "fail.rhai"], 65, &["frame 4"]);
}

#[test]
fn a_mesh_is_counted_and_its_flat_triangles_are_told() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n";
    let script = format!("{STILL}mesh(#{{ file: \"a.obj\", translate: [3, 0, 0] }});");
    let room = Room::with(&[("a.obj", obj), ("a.rhai", &script)]);
    let ran = room.good(&["check", "a.rhai"]);
    assert!(ran.text().contains("1 sphere, 1 mesh of 1 triangle\n"), "{}", ran.text());
    assert!(ran.err.contains("1 triangle without area skipped"), "{}", ran.err);
}

#[test]
fn nothing_in_view_is_told_with_its_cause() {
    let room = Room::with(&[]);
    let scene = |more: &str| {
        format!(
            "image(#{{ width: 160, height: 90 }});
camera(#{{ eye: [0, 0, 5], look_at: [0, 0, 9] }});
light(#{{ at: [3, 4, 5], emissivity: 40 }});
{more}"
        )
    };
    let ball = "sphere(#{ center: [0, 0, 0], radius: 1 });";
    let aside = "sphere(#{ center: [90, 0, 9], radius: 1 });";
    let there = "sphere(#{ center: [0, 0, 90], radius: 0.01 });";
    let turns = "let b = sphere(#{ center: [0, 0, 0], radius: 1 });
animation(#{ frames: 99 }); on_frame(|f| { if f.index == 50 { b.center.z = 9; } });";
    for (more, warning) in [
        ("", Some("there is no visible surface")),
        (ball, Some("all surfaces lie behind the camera; look the other way")),
        (aside, Some("of 96x54 rays from the camera none hits a surface; look_at a surface")),
        (there, None),
        // One frame is enough.
        (turns, None),
    ] {
        room.write("a.rhai", scene(more));
        let ran = room.good(&["check", "a.rhai"]);
        match warning {
            Some(why) => {
                assert_eq!(ran.err, format!("warning: nothing is in view: {why}\n"), "{more}");
            }
            None => assert_eq!(ran.err, "", "{more}"),
        }
    }
}

#[test]
fn a_sky_a_room_and_a_lamp_within_are_no_cause_for_alarm() {
    let room = Room::with(&[]);
    for more in [
        // A sky, with things in it.
        "sphere(#{ center: [0, 0, 0], radius: 900, material: #{ ambient: 500 } });",
        // A room: the lamp lights what the camera sees.
        "cuboid(#{ min: [-9, -9, -9], max: [9, 9, 9] });",
        // A lamp that is lit in one frame, behind a screen that is open.
        "let l = light(#{ at: [2, 0, 2], emissivity: 0 }); animation(#{ frames: 60 });
        on_frame(|f| { if f.index == 31 { l.emissivity = 9; } });",
        "light(#{ at: [3, 0, 0], emissivity: 9 });
        cylinder(#{ base: [3, -1, 0], axis: [0, 1, 0], radius: 1, height: 2, caps: false });",
    ] {
        room.write("a.rhai", format!("{STILL}{more}\n"));
        assert_eq!(room.good(&["check", "a.rhai"]).err, "", "{more}");
    }
    let mirror = "sphere(#{ center: [0, 0, 0], radius: 9, material: #{ specular: 0.9 } });";
    room.write(
        "a.rhai",
        format!("{STILL}{mirror}").replace(
            "sphere(#{ center: [0, 0, 0], radius: 1",
            "let x = (#{ center: [0, 0, 0], radius: 1",
        ),
    );
    assert_eq!(room.good(&["check", "a.rhai"]).err, "");
}

#[test]
fn an_error_in_any_frame_is_found() {
    let fail = |index: u32| {
        format!(
            "{STILL}animation(#{{ frames: 99 }}); on_frame(|f| {{ paint.diffuse = f.t; if f.index >= {index} && f.index < {index} + 10 {{ paint.x = 1; }} }});"
        )
    };
    let room = Room::with(&[("a.rhai", &fail(40)), ("five.rhai", &format!("{STILL}{FIVE}"))]);
    room.bad(&["check", "a.rhai"], 65, &["frame 4"]);
    room.bad(&["check", "a.rhai", "--frames", "all"], 65, &["frame 40"]);
    room.good(&["check", "a.rhai", "--frames", "0-39"]);
    room.bad(&["check", "five.rhai", "--frames", "5"], 2, &["--frames", "no frame 5"]);
    room.bad(&["check", "five.rhai", "--frames", "some"], 2, &["--frames", "or all"]);
}

#[test]
fn the_scenes_that_teach_are_without_warnings() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts");
    let room = Room::with(&[]);
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "rhai") {
            let ran = room.good(&["check", path.to_str().unwrap()]);
            let text = ran.text();
            assert!(text.ends_with("no warnings\n"), "{}: {}", path.display(), ran.err);
        }
    }
}
