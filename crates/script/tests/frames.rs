//! Frame k alone equals frame k of the run, bit for bit, whatever scripts do.

use reflet_scene::{
    Camera, Checker, Image, Key, Material, Mesh, Noun, Plane, PointLight, Quad, RandomStream,
    Scene, Settings, Sphere, Spotlight, Surface, Triangle,
};
use reflet_script::{Options, Source, Stage};
use std::fmt::Debug;

const CAMERA: &str = "camera(#{ eye: [0, 2, 8], look_at: [0, 1, 0] });\n";

fn load(script: &str) -> Stage {
    let text = format!("{CAMERA}{script}");
    let options = Options { print: Some(std::sync::Arc::new(|_, _| {})), ..Options::default() };
    match Stage::load(Source { path: "scene.rhai".into(), text }, &options) {
        Ok(stage) => stage,
        Err(error) => panic!("{error}"),
    }
}

fn frame(stage: &mut Stage, k: u32) -> Vec<String> {
    if let Err(error) = stage.frame(k) {
        panic!("{error}");
    }
    stage.with_scene(contents)
}

/// Everything in a scene, as text. `{:?}` of a float gives the same text for the same bits only
/// (there is no NaN in a scene).
fn contents(scene: &Scene) -> Vec<String> {
    fn add<N: Noun + Debug>(scene: &Scene, key: Key, line: &mut String) {
        if let Some(noun) = scene.get::<N>(key) {
            line.push_str(&format!(" {noun:?}"));
        }
    }
    scene
        .keys()
        .map(|key| {
            let mut line = format!("{key:?}");
            add::<Sphere>(scene, key, &mut line);
            add::<Plane>(scene, key, &mut line);
            add::<Quad>(scene, key, &mut line);
            add::<Triangle>(scene, key, &mut line);
            add::<Mesh>(scene, key, &mut line);
            add::<Surface>(scene, key, &mut line);
            add::<Material>(scene, key, &mut line);
            add::<Checker>(scene, key, &mut line);
            add::<PointLight>(scene, key, &mut line);
            add::<Spotlight>(scene, key, &mut line);
            add::<Camera>(scene, key, &mut line);
            add::<Image>(scene, key, &mut line);
            add::<Settings>(scene, key, &mut line);
            add::<RandomStream>(scene, key, &mut line);
            line
        })
        .collect()
}

/// Checks that frames do not depend on what ran before; returns them.
fn independent(script: &str) -> Vec<Vec<String>> {
    let mut run = load(script);
    let own = run.with_scene(contents);
    let frames = run.with_scene(|s| s.animation().frames);
    let forward: Vec<_> = (0..frames).map(|k| frame(&mut run, k)).collect();
    for k in (0..frames).rev() {
        assert_eq!(frame(&mut run, k), forward[k as usize], "backward, frame {k} of {script}");
        assert_eq!(
            frame(&mut load(script), k),
            forward[k as usize],
            "alone, frame {k} of {script}"
        );
    }
    run.rewind();
    assert_eq!(run.with_scene(contents), own, "rewound, {script}");
    // A script whose frames are all alike would test nothing.
    assert!(forward.windows(2).any(|w| w[0] != w[1]), "frames differ in {script}");
    forward
}

#[test]
fn captured_counters_start_anew() {
    let frames = independent(
        "let m = material(#{ diffuse: 1 });
         animation(#{ frames: 4 });
         let count = 10;
         on_frame(|f| { count += 1; m.diffuse = count + f.index; });",
    );
    assert!(frames[3].iter().any(|l| l.contains("diffuse: DVec3(14.0, 14.0, 14.0)")), "{frames:?}");
}

#[test]
fn random_streams_start_anew_and_copies_share_one() {
    independent(
        "let r = random(7);
         let other = r;
         let first = r.float();
         let m = material(#{ diffuse: first });
         animation(#{ frames: 4 });
         on_frame(|f| {
             for i in 0..f.index + 1 { m.diffuse = [r.float(), other.range(1, 3), r.int(0, 9)]; }
             m.specular = random(f.index).float();
             m.ambient = r.pick([0.1, 0.2, 0.3]);
         });",
    );
}

#[test]
fn arrays_maps_and_strings_start_anew() {
    independent(
        "let m = material(#{ diffuse: 1 });
         let list = [1, [2, 3], #{ a: [4] }];
         let map = #{ n: 0, inner: #{ v: vec3(1, 2, 3) } };
         let text = \"x\";
         animation(#{ frames: 4 });
         on_frame(|f| {
             list.push(f.index); list[1][0] += 1; list[2].a.push(1); list[2].b = 1;
             map.n += 2; map.inner.v.x += 1; map.fresh = 1; text += \"x\";
             m.diffuse = [list.len(), list[1][0] + list[2].a.len(), map.n + map.len() + text.len()];
             m.specular = map.inner.v * f.t;
         });",
    );
}

#[test]
fn closures_in_closures_and_in_containers_start_anew() {
    independent(
        "let m = material(#{ diffuse: 1 });
         let n = 0;
         let step = || { n += 1; n };
         let machine = #{ state: 0, next: |by| { n += by; n } };
         let list = [step];
         animation(#{ frames: 4 });
         on_frame(|f| {
             let inner = || { n += 100; step.call() };
             let a = inner.call();
             let b = machine.next.call(f.index);
             let c = list[0].call();
             m.diffuse = [a, b, c + n];
         });",
    );
}

#[test]
fn this_is_restored_and_constants_are_seen() {
    let frames = independent(
        "const SCALE = 3;
         const COUNT = || 1;
         fn twice() { this * 2 }
         fn grow() { this.push(1); this.len() }
         fn scaled(x) { x * global::SCALE }
         let m = material(#{ diffuse: 1 });
         let list = [0];
         let number = 4;
         animation(#{ frames: 3 });
         on_frame(|f| { m.diffuse = [scaled(f.index), list.grow(), number.twice()]; });",
    );
    assert!(frames[2].iter().any(|l| l.contains("diffuse: DVec3(6.0, 2.0, 8.0)")), "{frames:?}");
}

#[test]
fn a_constant_closure_keeps_no_count_between_frames() {
    independent(
        "let n = 0;
         const COUNT = || { n += 1; n };
         fn count() { global::COUNT.call() }
         let m = material(#{ diffuse: 1 });
         animation(#{ frames: 3 });
         on_frame(|f| { m.diffuse = [count(), f.index, 0]; });",
    );
}

#[test]
fn what_a_frame_makes_lives_for_that_frame() {
    let frames = independent(
        "let m = material(#{ diffuse: 1 });
         let kept = [];
         animation(#{ frames: 3 });
         on_frame(|f| {
             if !kept.is_empty() { kept[0].radius = 99; }
             for i in 0..f.index { kept.push(sphere(#{ center: [i, 0, 0], radius: 1, material: #{ diffuse: i } })); }
             light(#{ at: [0, 9, 0], emissivity: f.index + 1 });
         });",
    );
    assert_eq!(frames.iter().map(Vec::len).collect::<Vec<_>>(), [4, 6, 8]);
    assert!(frames.iter().flatten().all(|line| !line.contains("99")));
}

#[test]
fn large_arrays_of_handles_start_anew_however_they_are_changed() {
    let make = "let balls = [];
        for i in 0..400 { balls.push(sphere(#{ center: [i, 0, 0], radius: 1 })); }
        animation(#{ frames: 3 });\n";
    for change in [
        "on_frame(|f| { balls[0].radius += balls.len() + f.index; });",
        "on_frame(|f| { balls[0] = balls[1 + f.index]; balls[0].radius = 5; });",
        "on_frame(|f| { balls.push(balls[0]); balls[f.index].radius = balls.len(); });",
        "on_frame(|f| { let change = || balls.pop(); change.call(); balls[f.index].radius = balls.len(); });",
        "on_frame(|f| { balls = [balls[1], balls[2], balls[3]]; balls[f.index].radius = 5; });",
        "fn drop() { this.shift() } on_frame(|f| { balls.drop(); balls[f.index].radius = 5; });",
        "fn other() { this = 1; } on_frame(|f| { let b = balls[f.index]; balls[f.index].other(); b.radius = 3; });",
        "let remove = || balls.remove(0); on_frame(|f| { remove.call(); balls[f.index].radius = 5; });",
        "on_frame(|f| { balls.remove(0); }); on_frame(|f| { balls[f.index].radius = 5; });",
    ] {
        independent(&format!("{make}{change}"));
    }
}

#[test]
fn every_noun_comes_back() {
    independent(
        "let eye = image(#{ samples: 1 });
         let s = settings(#{});
         let a = material(#{ diffuse: 1 }); let b = material(#{});
         let tiles = checker(#{ even: a, odd: b });
         let p = plane(#{ point: [0, 0, 0], normal: [0, 1, 0], material: tiles });
         let q = quad(#{ corner: [0, 0, 0], u: [1, 0, 0], v: [0, 1, 0] });
         let t = triangle(#{ a: [0, 0, 0], b: [1, 0, 0], c: [0, 1, 0] });
         let l = light(#{ at: [0, 5, 0], emissivity: 1 });
         let k = spotlight(#{ at: [0, 5, 0], aim: [0, 0, 0], angle: 20, emissivity: 1 });
         animation(#{ frames: 3 });
         on_frame(|f| {
             let x = f.index;
             eye.samples = 1 + x; s.background = x; s.max_bounces = x; s.transfer = \"linear\";
             tiles.size = [1 + x, 2]; tiles.even = b; tiles.xdir = [1, 0, x];
             p.point.y = x; p.visible = x == 1; q.u.x = 1 + x; t.c = [0, 1, x]; t.material = a;
             l.at += x; k.angle = 20 + x; k.emissivity *= 0.5; a.diffuse *= x;
         });",
    );
}

#[test]
fn the_moment_is_what_the_manual_says() {
    let said = std::sync::Arc::new(std::sync::Mutex::new(Vec::new()));
    let sink = said.clone();
    let print = move |text: &str, line: usize| sink.lock().unwrap().push((line, text.to_owned()));
    let options = Options { print: Some(std::sync::Arc::new(print)), ..Options::default() };
    let text = format!(
        "{CAMERA}animation(#{{ frames: 5, fps: 2 }});\n\
         on_frame(|f| print([f.index, f.t, f.phase, f.time, f.frames, f.fps]));\n"
    );
    let mut stage = Stage::load(Source { path: "s.rhai".into(), text }, &options).unwrap();
    for k in [0, 2, 4] {
        stage.frame(k).unwrap();
    }
    assert_eq!(
        *said.lock().unwrap(),
        [
            (3, "[0, 0.0, 0.0, 0.0, 5, 2.0]".to_owned()),
            (3, "[2, 0.5, 0.4, 1.0, 5, 2.0]".to_owned()),
            (3, "[4, 1.0, 0.8, 2.0, 5, 2.0]".to_owned()),
        ]
    );
    let mut still = load("let m = material(#{}); on_frame(|f| { m.diffuse = 1 + f.t; });");
    assert!(frame(&mut still, 0).iter().any(|l| l.contains("diffuse: DVec3(1.0, 1.0, 1.0)")));
}

#[test]
fn functions_run_in_order_and_a_failed_frame_leaves_the_scripts_own_scene() {
    let mut stage = load(
        "let m = material(#{ diffuse: 1 });
         animation(#{ frames: 2 });
         on_frame(|f| { m.diffuse = 2; });
         on_frame(|f| { m.diffuse *= 3; });
         on_frame(|f| { m.specular = 1.0 / 0.0 * f.index; });",
    );
    let own = stage.with_scene(contents);
    assert!(stage.frame(0).is_err(), "inf * 0 is no number");
    assert_eq!(stage.with_scene(contents), own);
    let mut stage = load(
        "let m = material(#{ diffuse: 1 });
         on_frame(|f| { m.diffuse = 2; });
         on_frame(|f| { m.diffuse *= 3; });",
    );
    assert!(frame(&mut stage, 0).iter().any(|l| l.contains("diffuse: DVec3(6.0, 6.0, 6.0)")));
    assert_eq!(stage.with_scene(|s| s.touched().len()), 1);
}

#[test]
fn a_stage_may_move_to_another_thread() {
    let mut stage = load("let m = material(#{}); on_frame(|f| { m.diffuse = 1; });");
    let moved = std::thread::spawn(move || stage.frame(0).is_ok());
    assert!(moved.join().unwrap());
}
