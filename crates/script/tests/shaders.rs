//! A function of plain numbers, and the same recorded from a hit point, give the same.

use reflet_scene::program::{Binary, Coordinate, Op, Program, Unary};
use reflet_scene::{Key, Shader};
use reflet_script::{Options, Source, Stage};
use std::sync::{Arc, Mutex};

/// Functions of `x` and `y`. All numbers below are few bits long, so that no step rounds, in
/// whatever order it is taken.
const FUNCTIONS: &[&str] = &[
    "x % y",
    "x % 2",
    "x % -2.5",
    "7.5 % y",
    "-7 % y",
    "(x + y) % 1.0",
    "mod(x, y)",
    "mod(x, -2)",
    "mod(-7, y)",
    "x + y * 2 - 0.5",
    "-x / 4",
    "abs(x) + floor(y)",
    "min(x, y) - max(x, 0.5)",
    "clamp(x, -1, 1.5)",
    "lerp(x, y, 0.25)",
    "mix(x, 3, y)",
    "step(x, y) + 2 * step(0.5, x)",
    "smoothstep(-2, 2, x)",
    "sqrt(x * x)",
];

const VALUES: [f64; 9] = [-7.5, -6.0, -2.5, -1.0, -0.25, 0.5, 1.0, 3.0, 6.75];

/// What a program gives where x and y are these.
fn run(program: &Program, [x, y]: [f64; 2]) -> f64 {
    let mut steps: Vec<f64> = Vec::new();
    for op in &program.ops {
        let value = match *op {
            Op::Constant(c) => f64::from(c),
            Op::Coordinate(Coordinate::X) => x,
            Op::Coordinate(Coordinate::Y) => y,
            Op::Unary(f, a) => {
                let a = steps[a as usize];
                match f {
                    Unary::Negate => -a,
                    Unary::Abs => a.abs(),
                    Unary::Sqrt => a.sqrt(),
                    Unary::Floor => a.floor(),
                    other => panic!("no {other:?} above"),
                }
            }
            Op::Binary(f, a, b) => {
                let (a, b) = (steps[a as usize], steps[b as usize]);
                match f {
                    Binary::Add => a + b,
                    Binary::Subtract => a - b,
                    Binary::Multiply => a * b,
                    Binary::Divide => a / b,
                    Binary::Min => a.min(b),
                    Binary::Max => a.max(b),
                    Binary::Step => f64::from(u8::from(b >= a)),
                }
            }
            other => panic!("no {other:?} above"),
        };
        steps.push(value);
    }
    steps[program.colour[0] as usize]
}

#[test]
fn plain_and_symbolic_numbers_agree() {
    for function in FUNCTIONS {
        let calls = VALUES.iter().flat_map(|x| VALUES.map(|y| (*x, y)));
        let prints: Vec<String> =
            calls.clone().map(|(x, y)| format!("print(f({x:?}, {y:?}));")).collect();
        let text = format!(
            "fn f(x, y) {{ {function} }}
camera(#{{ eye: [0, 2, 8], look_at: [0, 1, 0] }});
let m = shader(#{{ base: material(#{{}}), diffuse: |p| f(p.x, p.y) }});
{}",
            prints.join("\n")
        );
        let said = Arc::new(Mutex::new(Vec::new()));
        let sink = said.clone();
        let print = move |text: &str, _: usize| sink.lock().unwrap().push(text.to_owned());
        let options = Options { print: Some(Arc::new(print)), ..Options::default() };
        let stage = Stage::load(Source { path: "scene.rhai".into(), text }, &options);
        let program = stage.unwrap_or_else(|e| panic!("{e}")).with_scene(|scene| {
            let shaders = (0..scene.len()).filter_map(|key| scene.get::<Shader>(Key(key)));
            shaders.last().and_then(|shader| shader.diffuse).expect("a recorded function")
        });
        let said = said.lock().unwrap();
        for ((x, y), plain) in calls.zip(said.iter()) {
            let plain: f64 = plain.parse().expect("a number");
            assert_eq!(run(&program, [x, y]), plain, "{function} of {x} and {y}");
        }
        assert_eq!(said.len(), VALUES.len() * VALUES.len());
    }
}
