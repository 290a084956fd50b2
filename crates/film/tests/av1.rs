//! AV1 films, read back by ffmpeg.
#![cfg(feature = "av1")]

mod common;

use common::bytes;
use reflet_film::{
    Compression, Dither, FilmSink, FilmSpec, FilmWriter, Format, Fps, Target, Transfer,
    VideoQuality, manifest_path, read_sealed,
};
use std::io::ErrorKind;
use std::process::Command;

fn spec(width: u32, height: u32) -> FilmSpec {
    FilmSpec {
        format: Format::Ivf,
        width,
        height,
        fps: Fps::new(30_000, 1001).unwrap(),
        frames: 12,
        transfer: Transfer::Srgb,
        compression: Compression::Fast,
        dither: Dither::None,
        spool: None,
    }
}

#[test]
fn the_same_frames_give_the_same_bytes_and_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("f.ivf");
    let target = Target::parse(path.as_os_str(), None, 12).unwrap();
    let write = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let sink = FilmSink::open(&target, VideoQuality::default(), Transfer::Srgb).unwrap();
            let mut writer = FilmWriter::new(sink, spec(66, 50)).unwrap();
            for step in 0..12 {
                let frame = bytes(66, 50, 16, |x, y| [(x * 3 + step) as u8, (y * 5) as u8, 90]);
                writer.push(&frame).unwrap();
            }
            writer.commit(&[("made-from", "a")]).unwrap();
        });
        std::fs::read(&path).unwrap()
    };
    let film = write(1);
    assert!(film == write(2) && film == write(5));
    assert_eq!(read_sealed(&path).unwrap(), [("made-from".to_owned(), "a".to_owned())]);
    assert!(manifest_path(&path).exists());
    let mut probe = Command::new("ffprobe");
    probe.args(["-v", "error", "-count_frames", "-of", "csv=p=0", "-show_entries"]);
    probe.arg("stream=codec_name,width,height,r_frame_rate,nb_read_frames").arg(&path);
    let Ok(told) = probe.output() else { return println!("skipped: ffmpeg is not there") };
    assert_eq!(String::from_utf8_lossy(&told.stdout).trim(), "av1,66,50,30000/1001,12");
    assert_eq!(String::from_utf8_lossy(&told.stderr), "");
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg
        .args(["-v", "error", "-i"])
        .arg(&path)
        .args(["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]);
    let pixels = ffmpeg.output().unwrap().stdout;
    assert_eq!(pixels.len(), 66 * 50 * 3 * 12);
    let wrong = pixels.iter().enumerate().map(|(i, value)| {
        let (frame, at) = (i / (66 * 50 * 3), i % (66 * 50 * 3));
        let (x, y) = (at / 3 % 66, at / 3 / 66);
        let want = [(x * 3 + frame) as u8, (y * 5) as u8, 90][at % 3];
        f64::from(value.abs_diff(want))
    });
    // A lossy format: near, and not shifted or in other colours.
    let mean = wrong.sum::<f64>() / pixels.len() as f64;
    assert!(mean < 3.0, "{mean}");
}

#[test]
fn pictures_too_small_for_av1_are_refused() {
    let error = FilmWriter::new(Vec::new(), spec(8, 8)).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidInput);
    assert!(error.to_string().starts_with("a film of 8 x 8 in AV1: "), "{error}");
}
