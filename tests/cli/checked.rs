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
            "sphere(#{ center: [0, 0, 0], radius: 9 });",
            "the camera at [0, 0, 5] is inside sphere 2 (center [0, 0, 0], radius 9)",
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
