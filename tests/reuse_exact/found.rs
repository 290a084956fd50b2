//! Scripts of which a frame once depended on those before it, each with its cause.

/// What went wrong, and the script.
pub const SCRIPTS: [(&str, &str); 6] = [
    (
        "edges were judged by nodes below a tile that reflects no longer",
        r#"
camera(#{ eye: [2, 3, 8], look_at: [0, 0.5, 0] });
image(#{ width: 80, height: 45, samples: 4, adaptive: true });
let k = checker(#{ even: #{ specular: 1 }, odd: #{ ambient: 0.1 } });
plane(#{ point: [0, 0, 0], normal: [0, 1, 0], material: k });
animation(#{ frames: 3 });
on_frame(|f| { k.size = [0.3 + f.t, 0.4]; });
"#,
    ),
    (
        "edges were not judged again where a material begins or ceases to reflect",
        r#"
camera(#{ eye: [2, 3, 8], look_at: [0, 0.5, 0] });
image(#{ width: 80, height: 45, samples: 4, adaptive: true });
let a = material(#{ ambient: 1 });
sphere(#{ center: [0, 1, 0], radius: 1, material: a });
plane(#{ point: [0, 0, 0], normal: [0, 1, 0], material: #{ ambient: 0.2 } });
animation(#{ frames: 3 });
on_frame(|f| { a.specular = [0, 0.5, 0][f.index]; });
"#,
    ),
    (
        "rows of a frame's own surfaces were compared twice, and not in order",
        r#"
camera(#{ eye: [0, 1, 7], look_at: [0, 1, 0] });
image(#{ width: 80, height: 45 });
let a = sphere(#{ center: [-2, 1, 0], radius: 0.3, material: #{ ambient: 0.5 } });
let b = sphere(#{ center: [2, 1, 0], radius: 0.3, material: #{ ambient: 0.7 } });
animation(#{ frames: 4 });
on_frame(|f| {
    sphere(#{ center: [f.t, 2, 0], radius: 0.2, material: #{ ambient: 1 } });
    a.center.x += f.t;
    instance(b, #{ translate: [0, -1, 0] });
    b.center.x -= f.t;
});
"#,
    ),
    (
        "packing anew read surfaces before the frame's own materials had rows",
        r#"
camera(#{ eye: [0, 1, 7], look_at: [0, 1, 0] });
image(#{ width: 80, height: 45 });
light(#{ at: [3, 5, 5], emissivity: 20 });
let s = sphere(#{ center: [0, 1, 0], radius: 0.5 });
let t = sphere(#{ center: [2, 1, 0], radius: 0.5 });
let g = group([s], #{ scale: [0.6, 1, 0.8] });
animation(#{ frames: 3 });
on_frame(|f| { g.scale = 1; t.material = #{ diffuse: 0.1 }; });
"#,
    ),
    (
        "a hidden surface took over other primitives, as many as there were before in all",
        r#"
camera(#{ eye: [0, 0, 5], look_at: [0, 0, 0] });
image(#{ width: 40, height: 30 });
sphere(#{ center: [-1.5, 0, 0], radius: 0.5, material: #{ ambient: 0.5 } });
animation(#{ frames: 2 });
on_frame(|f| {
    if f.index == 0 {
        cone(#{ apex: [0, 1, 0], axis: [0, -1, 0], radius: 0.5, height: 1, visible: false });
        cuboid(#{ center: [0, 0, 0], size: [1, 1, 1], material: #{ ambient: 0.2 } });
    } else {
        cuboid(#{ center: [0, 1, 0], size: [1, 1, 1], visible: false });
        quad(#{ corner: [0, 0, -1], u: [1, 0, 0], v: [0, 1, 0], material: #{ ambient: 1 } });
    }
});
"#,
    ),
    (
        "a texture without green let through no specular that was green alone, and then does",
        r#"
camera(#{ eye: [0, 0, 5], look_at: [0, 0, 0] });
image(#{ width: 40, height: 30 });
let paint = material(#{ ambient: 0.2, specular: [0, 0.5, 0] });
quad(#{ corner: [-1, -1, 0], u: [2, 0, 0], v: [0, 2, 0],
        material: textured(#{ base: paint, file: "a.ppm", filter: "nearest" }) });
sphere(#{ center: [0, 0, 6], radius: 1, material: #{ ambient: 1 } });
animation(#{ frames: 3 });
on_frame(|f| { if f.index == 1 { paint.specular = [0.8, 0.5, 0.7]; } });
"#,
    ),
];
