//! Files read by programs that share no code with this project: Pillow, ImageMagick (libpng and
//! others) and ffmpeg. A program that is not there is named and skipped, unless
//! `REFLET_REQUIRE_TOOLS=1`.

mod common;

use common::{balls, bytes, noise, rows};
use reflet_film::{
    Compression, Dither, FilmSpec, FilmWriter, Format, Fps, Picture, SampleKind, StillOptions,
    Transfer, encode_still,
};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The program's standard output; `None` if there is no such program.
fn run(program: &str, arguments: &[&str]) -> Option<Vec<u8>> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program} {arguments:?}: {text}");
    Some(output.stdout)
}

/// Says that a tool is missing, or fails where it must not be.
fn missing(tool: &str) {
    let required = std::env::var("REFLET_REQUIRE_TOOLS").is_ok_and(|value| value == "1");
    assert!(!required, "{tool} is not there");
    eprintln!("skipped: {tool} is not there");
}

fn has_pillow() -> bool {
    let python = Command::new("python3").args(["-c", "import PIL"]).output();
    python.is_ok_and(|output| output.status.success())
}

fn has(program: &str) -> bool {
    Command::new(program).arg("-version").output().is_ok()
}

fn save(
    folder: &Path,
    name: &str,
    picture: &Picture,
    format: Format,
    compression: Compression,
) -> PathBuf {
    let options =
        StillOptions { compression, text: &[("Software", "Reflet")], ..StillOptions::default() };
    let path = folder.join(name);
    let file = encode_still(picture, format, &options, None).unwrap();
    std::fs::write(&path, file.to_vec()).unwrap();
    path
}

fn pictures() -> Vec<Picture> {
    let any = |x, y| noise(x, y, 3).to_le_bytes()[..3].try_into().unwrap();
    vec![
        balls(320, 180, SampleKind::U8, 0.6),
        bytes(1, 1, 16, |_, _| [3, 2, 1]),
        bytes(1, 70, 16, any),
        bytes(333, 65, 16, any),
        bytes(200, 200, 16, |_, _| [9; 3]),
    ]
}

const PILLOW: &str = "
import sys
from PIL import Image
i = Image.open(sys.argv[1])
i.load()
sys.stdout.buffer.write(i.convert('RGB').tobytes())
";

const PILLOW_FRAMES: &str = "
import sys
from PIL import Image, ImageSequence
i = Image.open(sys.argv[1])
for f in ImageSequence.Iterator(i):
    sys.stdout.buffer.write(f.convert('RGB').tobytes())
";

#[test]
fn stills_are_read_alike() {
    let folder = tempfile::tempdir().unwrap();
    let pillow = has_pillow();
    let magick = ["magick", "convert"].into_iter().find(|program| has(program));
    let ffmpeg = has("ffmpeg");
    for (there, tool) in [(pillow, "Pillow"), (magick.is_some(), "ImageMagick"), (ffmpeg, "ffmpeg")]
    {
        if !there {
            missing(tool);
        }
    }
    for picture in pictures() {
        let want = rows::<u8>(&picture);
        let mut files = vec![
            save(folder.path(), "a.ppm", &picture, Format::Ppm, Compression::Fast),
            save(folder.path(), "a.qoi", &picture, Format::Qoi, Compression::Fast),
        ];
        for compression in [Compression::Fast, Compression::Balanced, Compression::Small] {
            let name = format!("{compression:?}.png");
            files.push(save(folder.path(), &name, &picture, Format::Png, compression));
        }
        for file in files {
            let path = file.to_str().unwrap();
            let is_png = path.ends_with(".png");
            if pillow {
                let found = run("python3", &["-c", PILLOW, path]).unwrap();
                assert!(found == want, "Pillow: {path}");
            }
            if let (Some(magick), true) = (magick, is_png) {
                let found = run(magick, &[path, "-depth", "8", "rgb:-"]).unwrap();
                assert!(found == want, "ImageMagick: {path}");
            }
            if ffmpeg && (is_png || path.ends_with(".ppm")) {
                let tail = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-"];
                let found = run("ffmpeg", &[&["-v", "error", "-i", path], &tail[..]].concat());
                assert!(found.unwrap() == want, "ffmpeg: {path}");
            }
        }
    }
}

#[test]
fn png_of_16_bits_is_read_alike() {
    let folder = tempfile::tempdir().unwrap();
    if !has("ffmpeg") {
        return missing("ffmpeg");
    }
    let picture = balls(160, 90, SampleKind::U16, 0.6);
    let file = save(folder.path(), "a.png", &picture, Format::Png16, Compression::Fast);
    let found = run(
        "ffmpeg",
        &[
            "-v",
            "error",
            "-i",
            file.to_str().unwrap(),
            "-f",
            "rawvideo",
            "-pix_fmt",
            "rgb48be",
            "-",
        ],
    );
    let want: Vec<u8> = rows::<u16>(&picture).iter().flat_map(|s| s.to_be_bytes()).collect();
    assert!(found.unwrap() == want);
}

/// Frames of few colours, so that a GIF of them loses nothing.
fn frames() -> Vec<Picture> {
    let draw = |step: u32| {
        bytes(96, 64, 16, move |x, y| {
            let inside = x / 8 == step && y / 16 == 1;
            [if inside { 240 } else { 20 }, (x / 12) as u8 * 30, (y / 16) as u8 * 60]
        })
    };
    [0, 1, 5, 5, 11, 2].map(draw).to_vec()
}

fn save_film(folder: &Path, name: &str, format: Format, frames: &[Picture]) -> String {
    let layout = frames[0].layout();
    let spec = FilmSpec {
        format,
        width: layout.width(),
        height: layout.height(),
        fps: Fps::new(24, 1).unwrap(),
        frames: frames.len() as u32,
        transfer: Transfer::Srgb,
        compression: Compression::Fast,
        dither: Dither::None,
        spool: None,
    };
    let mut writer = FilmWriter::new(Vec::new(), spec).unwrap();
    for frame in frames {
        writer.push(frame).unwrap();
    }
    let path = folder.join(name);
    let patch = writer.patch();
    let mut file = writer.finish().unwrap();
    if let Some(patch) = patch {
        let at = patch.offset as usize;
        file[at..at + 4].copy_from_slice(&patch.bytes);
    }
    std::fs::write(&path, file).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn films_are_read_alike() {
    let folder = tempfile::tempdir().unwrap();
    let frames = frames();
    let want: Vec<u8> = frames.iter().flat_map(rows::<u8>).collect();
    let gif = save_film(folder.path(), "a.gif", Format::Gif, &frames);
    let apng = save_film(folder.path(), "a.png", Format::Apng, &frames);
    let webp = save_film(folder.path(), "a.webp", Format::Webp, &frames);
    if has_pillow() {
        for path in [&gif, &apng, &webp] {
            let found = run("python3", &["-c", PILLOW_FRAMES, path]).unwrap();
            assert_eq!(found.len(), want.len(), "Pillow: {path}");
            assert!(found == want, "Pillow: {path}");
        }
    } else {
        missing("Pillow");
    }
    if has("ffmpeg") {
        for (path, demuxer) in [(&gif, "gif"), (&apng, "apng")] {
            let head = ["-v", "error", "-f", demuxer, "-i", path, "-fps_mode", "passthrough"];
            let tail = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-"];
            let found = run("ffmpeg", &[&head[..], &tail[..]].concat()).unwrap();
            assert_eq!(found.len(), want.len(), "ffmpeg: {path}");
            assert!(found == want, "ffmpeg: {path}");
        }
    } else {
        missing("ffmpeg");
    }
}

#[test]
fn y4m_is_read_with_its_range() {
    if !has("ffmpeg") {
        return missing("ffmpeg");
    }
    let folder = tempfile::tempdir().unwrap();
    let frames = [balls(160, 90, SampleKind::U8, 0.1), balls(160, 90, SampleKind::U8, 0.6)];
    let path = save_film(folder.path(), "a.y4m", Format::Y4m, &frames);
    let found = run(
        "ffmpeg",
        &[
            "-v",
            "error",
            "-i",
            &path,
            "-sws_flags",
            "accurate_rnd+full_chroma_int",
            "-f",
            "rawvideo",
            "-pix_fmt",
            "rgb24",
            "-",
        ],
    )
    .unwrap();
    let want: Vec<u8> = frames.iter().flat_map(rows::<u8>).collect();
    assert_eq!(found.len(), want.len());
    // Luma and chroma rounded to half a level move R, G and B by at most 0.5 + 0.886, and the
    // converter rounds once more and works in 14 bits: 2 levels. A range taken for limited would
    // move them by up to 18.
    let worst = found.iter().zip(&want).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(worst <= Some(2), "{worst:?}");
}
