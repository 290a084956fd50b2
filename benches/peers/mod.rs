//! Other tracers on the scene of `mirrors-10`, and what a process takes.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// The middle one.
pub fn median(mut figures: Vec<f64>) -> f64 {
    figures.sort_by(f64::total_cmp);
    figures.get(figures.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Seconds that a process took.
#[derive(Clone, Copy)]
pub struct Figures {
    pub wall: f64,
    /// Of all its threads, in the program and in the system for it.
    pub cpu: f64,
}

impl Figures {
    pub fn of(command: &mut Command) -> Figures {
        let (start, before) = (Instant::now(), children_cpu());
        let ran = command.stdout(Stdio::null()).stderr(Stdio::null()).status();
        assert!(ran.is_ok_and(|status| status.success()), "{command:?}");
        Figures { wall: start.elapsed().as_secs_f64(), cpu: children_cpu() - before }
    }

    pub fn per_frame(self, frames: u32) -> Figures {
        let frames = f64::from(frames);
        Figures { wall: self.wall / frames, cpu: self.cpu / frames }
    }

    pub fn median(all: &[Figures]) -> Figures {
        let of = |part: fn(&Figures) -> f64| median(all.iter().map(part).collect());
        Figures { wall: of(|f| f.wall), cpu: of(|f| f.cpu) }
    }
}

#[cfg(unix)]
fn children_cpu() -> f64 {
    use nix::sys::resource::{UsageWho, getrusage};
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).expect("the system counts");
    let seconds = |t: nix::sys::time::TimeVal| t.tv_sec() as f64 + t.tv_usec() as f64 / 1e6;
    seconds(usage.user_time()) + seconds(usage.system_time())
}

/// Not told here.
#[cfg(not(unix))]
fn children_cpu() -> f64 {
    f64::NAN
}

/// Another tracer. It renders the first frame of `mirrors-10`: none gets cheaper by knowing the
/// frame before.
#[derive(Clone, Copy)]
pub enum Peer {
    Tachyon,
    PovRay,
}

/// Where the ten balls are, their radius, diffuse colour and specular reflectivity in frame 0.
fn balls() -> impl Iterator<Item = ([f64; 3], f64, [f64; 3], [f64; 3])> {
    (0..10).map(|i| {
        let turn = f64::to_radians(40.0 * f64::from(i - 1));
        let (at, radius) = match i {
            0 => ([0.0, 1.2, 0.0], 1.2),
            _ => ([3.0 * turn.cos(), 0.8, 3.0 * turn.sin()], 0.8),
        };
        let wave = |f: fn(f64) -> f64| [0.0, 2.0, 4.0].map(|c| f(f64::from(i) + c));
        let diffuse = wave(f64::cos).map(|c| 0.5 * (0.5 + 0.4 * c));
        (at, radius, diffuse, wave(f64::sin).map(|s| 0.5 + 0.4 * s))
    })
}

impl Peer {
    pub const ALL: [Peer; 2] = [Peer::Tachyon, Peer::PovRay];

    pub fn name(self) -> &'static str {
        match self {
            Peer::Tachyon => "tachyon",
            Peer::PovRay => "povray",
        }
    }

    /// What renders one frame, if the peer is installed.
    pub fn command(self, folder: &Path) -> Option<Box<dyn Fn() -> Command>> {
        let found = std::env::var_os("PATH").is_some_and(|path| {
            std::env::split_paths(&path).any(|folder| folder.join(self.name()).is_file())
        });
        if !found {
            return None;
        }
        let (scene, text) = match self {
            Peer::Tachyon => (folder.join("mirrors.dat"), tachyon()),
            Peer::PovRay => (folder.join("mirrors.pov"), povray()),
        };
        std::fs::write(&scene, text).expect("a scene for a peer");
        let out = folder.join(format!("{}.png", self.name()));
        Some(Box::new(move || self.call(&scene, &out)))
    }

    fn call(self, scene: &PathBuf, out: &PathBuf) -> Command {
        let mut command = Command::new(self.name());
        match self {
            Peer::Tachyon => {
                command.arg(scene).args(["-numthreads", "2", "-format", "PNG", "-o"]).arg(out);
            }
            Peer::PovRay => {
                command.arg(format!("+I{}", scene.display()));
                command.arg(format!("+O{}", out.display()));
                command.args(["+W640", "+H360", "-A", "-D", "-GA", "+WT2", "+FN8"]);
            }
        }
        command
    }
}

/// Left-handed, so x is mirrored; one specular number a ball, the mean.
fn tachyon() -> String {
    let mut text = String::from(
        "BEGIN_SCENE\nRESOLUTION 640 360\nCAMERA\nZOOM 2.1445\nASPECTRATIO 1.0\nANTIALIASING 0\n\
         RAYDEPTH 6\nCENTER 0 2.5 -9\nVIEWDIR 0 -0.1854 0.9827\nUPDIR 0 1 0\nEND_CAMERA\n\
         BACKGROUND 0 0 0\nLIGHT CENTER -6 9 -6 RAD 0.01 COLOR 0.7 0.7 0.7\n\
         LIGHT CENTER 7 6 -4 RAD 0.01 COLOR 0.5 0.5 0.5\n\
         PLANE CENTER 0 0 0 NORMAL 0 1 0 TEXTURE AMBIENT 0 DIFFUSE 0.9 SPECULAR 0 OPACITY 1 \
         COLOR 1 1 1 TEXFUNC 1 CENTER 0 0 0 ROTATE 0 0 0 SCALE 1 1 1\n",
    );
    for ([x, y, z], radius, [r, g, b], specular) in balls() {
        let mean = specular.iter().sum::<f64>() / 3.0;
        let _ = writeln!(
            text,
            "SPHERE CENTER {} {y} {z} RAD {radius} TEXTURE AMBIENT 0 DIFFUSE 1 SPECULAR {mean} \
             OPACITY 1 COLOR {r} {g} {b} TEXFUNC 0",
            -x
        );
    }
    text + "END_SCENE\n"
}

fn povray() -> String {
    let mut text = String::from(
        "#version 3.7;\nglobal_settings { assumed_gamma 1 max_trace_level 6 }\n\
         camera { location <0,2.5,-9> right x*16/9 up y look_at <0,0.8,0> angle 50 }\n\
         light_source { <6,9,-6> rgb 0.7 }\nlight_source { <-7,6,-4> rgb 0.5 }\n\
         plane { y, 0 pigment { checker rgb 0.9 rgb <0.2,0.2,0.25> } \
         finish { ambient 0 diffuse 1 } }\n",
    );
    for ([x, y, z], radius, [r, g, b], [sr, sg, sb]) in balls() {
        let _ = writeln!(
            text,
            "sphere {{ <{x},{y},{z}>, {radius} pigment {{ rgb <{r},{g},{b}> }} \
             finish {{ ambient 0 diffuse 1 reflection {{ rgb <{sr},{sg},{sb}> }} }} }}"
        );
    }
    text
}
