//! Bytes are counted where they are allocated, in a process of one test at a time.

use cap::Cap;
use reflet_script::{Options, ScriptError, Source, Stage};
use std::alloc::System;
use std::sync::{Arc, Mutex};

#[global_allocator]
static HEAP: Cap<System> = Cap::new(System, usize::MAX);

const CAMERA: &str = "camera(#{ eye: [0, 2, 8], look_at: [0, 1, 0] });\n";

fn run(script: &str, max_memory: u64) -> Result<Stage, ScriptError> {
    let options = Options {
        max_memory,
        heap: Some(|| HEAP.allocated() as u64),
        slow: Some(Arc::new(|_| {})),
        print: Some(Arc::new(|_, _| {})),
        ..Options::default()
    };
    Stage::load(Source { path: "scene.rhai".into(), text: format!("{CAMERA}{script}") }, &options)
}

#[test]
fn memory_is_bounded_and_given_back() {
    const LIMIT: u64 = 64 << 20;
    for script in [
        "let a = []; for i in 0..40 { a = [a, a]; }",
        "let s = \"a\"; loop { s += s; }",
        "let s = \"a\"; loop { s = `${s}${s}`; }",
        "let a = []; let s = \"x\"; for i in 0..16 { s += s; } loop { a.push(s + `${a.len()}`); }",
        "let b = \"\"; b.pad(9000, 'x'); b = b.to_blob(); let a = []; loop { a.push(b); }",
        "let m = #{}; let i = 0; loop { m[`k${i}`] = i; i += 1; }",
        "let h = 0; loop { let prev = h; h = || prev; }",
        "let h = 0; loop { let prev = h; h = [[[[[[[[|| prev]]]]]]]]; }",
        "let a = []; a.pad(1000000, 1); let b = [a]; loop { b.push(b); }",
        "let a = [1]; loop { a.append(a); }",
        "loop { sphere(#{ center: [0, 0, 0], radius: 1 }); }",
        "fn f(a) { a.push([a, a]); f(a) } f([]);",
        "let all = []; let h = 0; loop { let p = h; h = || p; all.push(h); }",
    ] {
        let error = run(script, LIMIT).unwrap_err();
        let known = error.message.contains("--max-memory allows more")
            || error.message.starts_with("calls nest deeper");
        assert!(known, "{script}: {error}");
        assert_eq!(error.place.map(|p| p.line), Some(2), "{script}");
        assert!((HEAP.allocated() as u64) < LIMIT / 2, "{script}: {}", HEAP.allocated());
    }

    // What a frame leaves is freed at its end, on a stack that is large enough.
    let grows = "let head = 0; let s = []; animation(#{ frames: 9 });
        on_frame(|f| { for i in 0..60000 { let prev = head; head = || prev; } s.push(head); });";
    let mut stage = run(grows, 256 << 20).unwrap();
    let before = HEAP.allocated();
    for frame in 0..9 {
        stage.frame(frame).unwrap();
        assert!(HEAP.allocated() < before + (1 << 20), "{frame}");
    }
    drop(stage);
    // Chains that the script leaves, each link held by an array, too.
    let chains = "let all = []; let head = 0;
        for i in 0..60000 { let prev = head; head = || prev; all.push(head); }
        on_frame(|f| { all.len(); });";
    drop(run(chains, 256 << 20));
    drop(run(&format!("{chains} throw 1;"), 256 << 20));
    // Captured values are held twice.
    let large = "let s = []; for i in 0..700000 { s.push(`a longer string ${i}`); }";
    assert!(run(large, 256 << 20).is_ok());
    let error = run(&format!("{large} on_frame(|f| {{ s.len(); }});"), 256 << 20);
    drop(error);

    let flood: Arc<Mutex<usize>> = Arc::default();
    let said = flood.clone();
    let options = Options {
        print: Some(Arc::new(move |text, _| *said.lock().unwrap() += text.len())),
        slow: Some(Arc::new(|_| {})),
        max_operations: 1_000_000,
        ..Options::default()
    };
    let text = format!("{CAMERA}let s = \"\"; s.pad(99999, 'a'); loop {{ print(s); }}");
    assert!(Stage::load(Source { path: "s.rhai".into(), text }, &options).is_err());
    assert!(*flood.lock().unwrap() <= 1 << 20);
}
