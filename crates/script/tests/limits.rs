//! Whatever a script does ends with a message and a line, never with a signal.

use reflet_script::{Options, ScriptError, Source, Stage};

const CAMERA: &str = "camera(#{ eye: [0, 2, 8], look_at: [0, 1, 0] });\n";

fn run(script: &str, options: &Options) -> Result<Stage, ScriptError> {
    let text = format!("{CAMERA}{script}");
    let mut options = options.clone();
    options.slow = Some(std::sync::Arc::new(|_| {}));
    Stage::load(Source { path: "scene.rhai".into(), text }, &options)
}

fn error(script: &str) -> ScriptError {
    run(script, &Options { max_operations: 10_000_000, ..Options::default() }).unwrap_err()
}

#[test]
fn growth_ends_with_a_message() {
    for script in [
        "let x = [0]; for i in 0..60 { x = [x, x]; }",
        "let x = [0]; for i in 0..60 { x.append(x); }",
        "let x = [0]; for i in 0..60 { x.push(x); }",
        "let x = #{ a: 0 }; for i in 0..60 { x = #{ a: x, b: x }; }",
        "let x = \"12345678\"; for i in 0..60 { x += x; }",
        "let x = \"12345678\"; for i in 0..60 { x = x + x; }",
        "let x = \"12345678\"; for i in 0..60 { x = `${x}${x}`; }",
        "let x = []; loop { x.push(\"a string of some length\".to_chars()); }",
    ] {
        // The memory of the whole process is watched, and the other tests here may trip this limit
        // early: the message is the same.
        let options =
            Options { max_operations: 10_000_000, max_memory: 64 << 20, ..Options::default() };
        let error = run(script, &options).unwrap_err();
        assert_eq!(error.place.as_ref().map(|p| p.line), Some(2), "{script}: {error}");
        let known = error.message.starts_with("the script holds too much memory")
            || error.message.starts_with("more than 10000000 operations");
        assert!(known, "{script}: {error}");
    }
}

#[test]
fn what_would_grow_in_one_step_is_refused_before() {
    for (script, message) in [
        ("let a = []; a.pad(100000000000, 1);", "the array would be longer than 16777216"),
        ("let a = \"\"; a.pad(100000000000, \"ab\");", "the string would be longer than 16777216"),
        ("let a = \"\"; a.pad(100000000000, 'a');", "the string would be longer than 16777216"),
        (
            "let s = \"\"; s.pad(5000, 'a'); s.replace(\"a\", s);",
            "the string would be longer than 16777216",
        ),
        (
            "let s = \"aaaaaaaa\"; let b = [s]; b.pad(10000, 0); for i in 0..9 { let c = []; c.pad(1000000, b); }",
            "the script holds too much memory: its strings, arrays and maps take more than 256 MiB, a quarter of the 1024 MiB allowed (the rest is for copies); --max-memory allows more",
        ),
        (
            "let a = []; a.pad(16000000, #{ a: 1 });",
            "the script holds too much memory: its strings, arrays and maps take more than 256 MiB, a quarter of the 1024 MiB allowed (the rest is for copies); --max-memory allows more",
        ),
    ] {
        let error = error(script);
        assert_eq!(error.message, message, "{script}");
        assert_eq!(error.place.map(|p| p.line), Some(2), "{script}");
    }
}

#[test]
fn depth_ends_with_a_message() {
    let deep = |open: &str, close: &str| {
        format!("let x = {}1{};", open.repeat(5_000), close.repeat(5_000))
    };
    for script in [
        deep("(", ")"),
        deep("[", "]"),
        deep("#{a:", "}"),
        deep("{", "}"),
        deep("|a| ", ""),
        deep("!", ""),
        format!("let x = 1{};", " + 1".repeat(50_000)),
        format!("let x = #{{}}; x{};", ".a".repeat(50_000)),
        format!("if true {{}} {}", "else if true {} ".repeat(5_000)),
    ] {
        let error = error(&script);
        assert!(error.message.contains("nests too deep"), "{error}");
        assert_eq!(error.place.map(|p| p.line), Some(2));
    }
    for (script, message) in [
        ("fn f(x) { f(x + 1) } f(0);", "calls nest deeper than 256: a recursion without an end?"),
        (
            "let x = [0]; for i in 0..400 { x = [x]; } print(x);",
            "arrays and maps stand in each other deeper than 256",
        ),
        (
            "let x = [0]; for i in 0..400 { x = [x]; } let y = x; let same = x == y;",
            "arrays and maps stand in each other deeper than 256",
        ),
        (
            "let x = [0]; for i in 0..400 { x = [x]; }",
            "arrays and maps stand in each other deeper than 256",
        ),
    ] {
        let error = error(script);
        assert_eq!(error.message, message, "{script}");
        assert_eq!(error.place.map(|p| p.line), Some(2), "{script}");
    }
}

#[test]
fn a_chain_of_300_000_closures_ends_with_a_message() {
    let message = "closures capture each other in a chain longer than 10000";
    let options = Options::default();
    let chain = "let f = || 0;\nfor i in 0..300000 { let g = f; f = || g.call(); }\n";
    let said = run(chain, &options).unwrap_err();
    assert_eq!((said.message.as_str(), said.place.map(|p| p.line)), (message, Some(2)));
    let said = run(&format!("{chain}f.call();"), &options).unwrap_err();
    assert_eq!(said.message, "calls nest deeper than 256: a recursion without an end?");
    // Dropped inside the script: nothing is left to complain of, and nothing overflows.
    let dropped = "fn link(g) { || g.call() }\nfn build() { let f = || 0; for i in 0..300000 { f = link(f); } 1 }\nbuild();";
    assert!(run(dropped, &options).is_ok());
}

#[test]
fn endless_scripts_end_with_a_line() {
    for script in [
        "loop { }",
        "while true { let x = 1; }",
        "for i in 0..9000000000000000000 { }",
        "let a = [1, 2, 3]; loop { a.map(|x| x + 1); }",
        "try { loop { } } catch { }",
    ] {
        let error = error(script);
        assert!(error.message.starts_with("more than 10000000 operations"), "{script}: {error}");
        assert_eq!(error.place.map(|p| p.line), Some(2), "{script}");
    }
    let mut stage =
        run("on_frame(|f| { loop { } });", &Options { max_operations: 1000, ..Options::default() })
            .unwrap();
    assert_eq!(stage.frame(0).unwrap_err().place.map(|p| p.line), Some(2));
}

#[test]
fn each_frame_has_the_whole_allowance() {
    let script = "animation(#{ frames: 50 });\non_frame(|f| { for i in 0..100 { } });";
    let mut stage = run(script, &Options { max_operations: 500, ..Options::default() }).unwrap();
    assert!((0..50).all(|k| stage.frame(k).is_ok()));
}

#[test]
fn long_scripts_are_bounded() {
    let said = error(&"let x = 1;\n".repeat(70_000)).message;
    assert!(said.starts_with("the script is longer than 65535 lines"), "{said}");
    // Rhai reads this in the square of its length: it is refused after a bounded time.
    let many: String = (0..40_000).map(|i| format!("let v{i} = v{};\n", i / 2)).collect();
    let said = error(&format!("let v0 = 0;\n{}", &many[many.find('\n').unwrap() + 1..])).message;
    assert!(said.contains("variables are too many for a script of this length"), "{said}");
    let keys: String = (0..100_000).map(|i| format!("k{i}: 1, ")).collect();
    let said = error(&format!("let x = #{{ {keys} }};")).message;
    assert!(said.contains("keys are too many for a map that is written out"), "{said}");
    for many in ["fn f{i}(x) { x } ", "let x = |x| x; "] {
        let many: String = (0..60_000).map(|i| many.replace("{i}", &i.to_string())).collect();
        let said = error(&many).message;
        assert!(said.contains("too many for a script"), "{said}");
    }
    let said = error("for i in 0..200000 { param(`p${i}`, 1, 0, 2); }").message;
    assert_eq!(said, "a scene has at most 4096 parameters");
}

#[test]
fn large_groups_are_made_in_linear_time() {
    let script = "let all = []; for i in 0..100000 { all.push(sphere(#{ center: [i, 0, 0], radius: 1 })); } group(all);";
    run(script, &Options::default()).unwrap();
    let said = error("let s = sphere(#{ center: [0, 0, 0], radius: 1 }); group([s, s]);").message;
    assert_eq!(said, "a sphere at 1 is in the array twice");
}

#[test]
fn what_natives_touch_counts_as_operations() {
    let long = "let s = \"\"; s.pad(90000, 'a'); let t = s + \"b\"; ";
    for script in [
        "loop { s == t }",
        "loop { s < t }",
        "loop { [s] == [t] }",
        "loop { let u = s; u.replace(\"a\", \"c\"); }",
        "loop { s.split(\"\").len() }",
        "loop { let u = \"\"; u.pad(99999, 'x'); }",
        "let a = [1]; a.pad(10000, 1); loop { a == a }",
        "let a = [1]; a.pad(10000, 1); loop { a.to_string() }",
    ] {
        let options = Options { max_operations: 1_000_000, ..Options::default() };
        let begin = std::time::Instant::now();
        let error = run(&format!("{long}{script}"), &options).unwrap_err();
        assert!(error.message.starts_with("more than 1000000 operations"), "{script}: {error}");
        // By operations alone each would take minutes.
        assert!(begin.elapsed().as_secs() < 20, "{script}: {:?}", begin.elapsed());
    }
}

#[test]
fn files_clock_and_entropy_are_out_of_reach() {
    for script in [
        "open_file(\"x\");",
        "timestamp();",
        "sleep(1);",
        "exit();",
        "eval(\"1\");",
        "import \"x\" as x;",
        "let f = |a, b| a; f.curry(1);",
        "export const X = 1;",
        "blob(9);",
        "parse_json(\"1\");",
        "let now = timestamp;",
    ] {
        assert!(run(script, &Options::default()).is_err(), "{script}");
    }
}
