//! Films, read back by other people's decoders.

mod common;

use common::{bytes, noise, rows};
use reflet_film::{
    Compression, Dither, FilmSink, FilmSpec, FilmWriter, Format, Fps, Picture, Pushed, Target,
    TileRect, Transfer, Unsealed, VideoQuality, manifest_path, needs_manifest, read_sealed,
};
use std::io::{self, Cursor, ErrorKind, Write};
use std::path::PathBuf;

const WIDTH: u32 = 70;
const HEIGHT: u32 = 50;

fn spec(format: Format, fps: u32, frames: u32) -> FilmSpec {
    FilmSpec {
        format,
        width: WIDTH,
        height: HEIGHT,
        fps: Fps::new(fps, 1).unwrap(),
        frames,
        transfer: Transfer::Srgb,
        compression: Compression::Fast,
        dither: Dither::None,
        spool: None,
    }
}

/// A square of 6 x 4 pixels that wanders over a ground of few colours, and stands still once.
const PLACES: [(u32, u32); 6] = [(0, 0), (10, 3), (10, 3), (64, 46), (31, 20), (0, 0)];

fn wandering() -> Vec<Picture> {
    let draw = |(left, top): (u32, u32)| {
        bytes(WIDTH, HEIGHT, 16, move |x, y| {
            let inside = (left..left + 6).contains(&x) && (top..top + 4).contains(&y);
            match inside {
                true => [250, (x - left) as u8, (y - top) as u8],
                false => [10, (x / 10) as u8 * 20, (y / 10) as u8 * 20],
            }
        })
    };
    PLACES.map(draw).to_vec()
}

fn film(spec: FilmSpec, frames: &[Picture]) -> (Vec<u8>, Vec<Pushed>) {
    let mut writer = FilmWriter::new(Vec::new(), spec).unwrap();
    let pushed = frames.iter().map(|frame| writer.push(frame).unwrap()).collect();
    (writer.finish().unwrap(), pushed)
}

/// The rectangle of pixels that differ between wandering frames `i - 1` and `i`.
fn between(i: usize) -> TileRect {
    let ((x0, y0), (x1, y1)) = (PLACES[i - 1], PLACES[i]);
    let (x, y) = (x0.min(x1), y0.min(y1));
    TileRect { x, y, width: x0.max(x1) + 6 - x, height: y0.max(y1) + 4 - y }
}

fn hold_stored(pushed: &[Pushed]) {
    for (i, pushed) in pushed.iter().enumerate() {
        let (stored, changed) = match i {
            0 => (TileRect { x: 0, y: 0, width: WIDTH, height: HEIGHT }, true),
            2 => (TileRect { x: 0, y: 0, width: 1, height: 1 }, false),
            _ => (between(i), true),
        };
        assert_eq!((pushed.stored, pushed.changed), (stored, changed), "frame {i}");
    }
}

#[test]
fn gif_frames_come_back() {
    let frames = wandering();
    let (file, pushed) = film(spec(Format::Gif, 24, 6), &frames);
    hold_stored(&pushed);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(Cursor::new(&file)).unwrap();
    assert_eq!((decoder.width(), decoder.height()), (70, 50));
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    let mut canvas = vec![0_u8; (WIDTH * HEIGHT * 3) as usize];
    let mut delays = Vec::new();
    for (frame, pushed) in frames.iter().zip(&pushed) {
        let read = decoder.read_next_frame().unwrap().unwrap();
        let stored = pushed.stored;
        assert_eq!(
            [read.left, read.top, read.width, read.height].map(u32::from),
            [stored.x, stored.y, stored.width, stored.height]
        );
        assert_eq!(read.dispose, gif::DisposalMethod::Keep);
        for (i, pixel) in read.buffer.chunks_exact(4).enumerate() {
            let (x, y) = (i as u32 % stored.width, i as u32 / stored.width);
            let at = (((stored.y + y) * WIDTH + stored.x + x) * 3) as usize;
            if pixel[3] > 0 {
                canvas[at..at + 3].copy_from_slice(&pixel[..3]);
            }
        }
        // Few colours: no loss.
        assert!(canvas == rows::<u8>(frame));
        delays.push(read.delay);
    }
    assert!(decoder.read_next_frame().unwrap().is_none());
    // 100/24 = 4.1666...: ends at 4.17, 8.33, 12.5, 16.67, 20.83, 25 hundredths.
    assert_eq!(delays, [4, 4, 5, 4, 4, 4]);
}

#[test]
fn gif_of_many_colours_keeps_them_near() {
    let draw = |step: u32| {
        bytes(WIDTH, HEIGHT, 16, move |x, y| [(x * 3) as u8, (y * 5) as u8, (x + y + step) as u8])
    };
    let frames = [draw(0), draw(1)];
    let (file, _) = film(spec(Format::Gif, 10, 2), &frames);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(Cursor::new(&file)).unwrap();
    for frame in &frames {
        let read = decoder.read_next_frame().unwrap().unwrap();
        let want = rows::<u8>(frame);
        let pixels = read.buffer.chunks_exact(4).zip(want.chunks_exact(3));
        let sum: f64 = pixels
            .map(|(a, b)| (0..3).map(|c| (f64::from(a[c]) - f64::from(b[c])).powi(2)).sum::<f64>())
            .sum();
        // A sheet of colours of 210 x 250 x 120 levels cut into 255 squares has a mean squared
        // error of about (210 * 250 / 255) / 12 on two axes and a third of that on the last:
        // 40 in all. Twice that for boxes that are not squares.
        let error = sum / f64::from(WIDTH * HEIGHT);
        assert!(error < 80.0, "{error}");
    }
}

/// One palette for all frames: a colour that is seen again has the same index and the same entry.
#[test]
fn gif_has_one_palette() {
    let (file, _) = film(spec(Format::Gif, 24, 6), &wandering());
    let mut decoder = gif::DecodeOptions::new().read_info(Cursor::new(&file)).unwrap();
    assert!(decoder.global_palette().is_some());
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        assert!(frame.palette.is_none());
    }
}

#[test]
fn webp_frames_come_back() {
    let frames = wandering();
    let mut writer = FilmWriter::new(Vec::new(), spec(Format::Webp, 24, 6)).unwrap();
    let pushed: Vec<_> = frames.iter().map(|frame| writer.push(frame).unwrap()).collect();
    hold_stored(&pushed);
    let patch = writer.patch().unwrap();
    let mut file = writer.finish().unwrap();
    let at = patch.offset as usize;
    file[at..at + 4].copy_from_slice(&patch.bytes);
    assert_eq!(u32::from_le_bytes(patch.bytes) as usize, file.len() - 8);
    let mut decoder = image_webp::WebPDecoder::new(Cursor::new(&file)).unwrap();
    assert_eq!(decoder.dimensions(), (WIDTH, HEIGHT));
    assert_eq!((decoder.num_frames(), decoder.has_alpha()), (6, false));
    let mut lasts = Vec::new();
    for frame in &frames {
        let mut pixels = vec![0; decoder.output_buffer_size().unwrap()];
        lasts.push(decoder.read_frame(&mut pixels).unwrap());
        assert!(pixels == rows::<u8>(frame));
    }
    // 1000/24 = 41.666...
    assert_eq!(lasts, [42, 41, 42, 42, 41, 42]);
}

#[test]
fn apng_frames_come_back() {
    let frames = wandering();
    for compression in [Compression::Fast, Compression::Small] {
        let spec = FilmSpec { compression, ..spec(Format::Apng, 24, 6) };
        let (file, pushed) = film(spec, &frames);
        hold_stored(&pushed);
        let mut reader = png::Decoder::new(Cursor::new(&file)).read_info().unwrap();
        let control = *reader.info().animation_control().unwrap();
        assert_eq!((control.num_frames, control.num_plays), (6, 0));
        let mut canvas = vec![0_u8; (WIDTH * HEIGHT * 3) as usize];
        for (frame, pushed) in frames.iter().zip(&pushed) {
            let mut samples = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut samples).unwrap();
            let control = *reader.info().frame_control().unwrap();
            let stored = pushed.stored;
            assert_eq!(
                [control.x_offset, control.y_offset, control.width, control.height],
                [stored.x, stored.y, stored.width, stored.height]
            );
            assert_eq!((control.delay_num, control.delay_den), (1, 24));
            assert_eq!(control.dispose_op, png::DisposeOp::None);
            assert_eq!(control.blend_op, png::BlendOp::Source);
            let width = stored.width as usize * 3;
            let read = samples.chunks_exact(width).take(stored.height as usize);
            for (y, row) in read.enumerate() {
                let at = ((stored.y as usize + y) * WIDTH as usize + stored.x as usize) * 3;
                canvas[at..at + width].copy_from_slice(row);
            }
            assert!(canvas == rows::<u8>(frame));
        }
    }
}

#[test]
fn rows_that_do_not_change_are_not_stored_twice() {
    // Noise does not compress, so the size says how many rows are stored.
    let draw = |seed: u32| {
        bytes(WIDTH, HEIGHT, 16, move |x, y| {
            let seed = if y == 20 { seed } else { 0 };
            noise(x, y, seed).to_le_bytes()[..3].try_into().unwrap()
        })
    };
    let count = 40;
    let frames: Vec<Picture> = (0..count).map(draw).collect();
    let row = WIDTH as usize * 3;
    for format in [Format::Gif, Format::Apng] {
        let first = film(spec(format, 24, 1), &frames[..1]).0.len();
        let all = film(spec(format, 24, count), &frames).0.len();
        let each = (all - first) / (count as usize - 1);
        // One row of 210 bytes and the frame's own heads: 78 bytes of chunks in APNG; a palette
        // of 70 to 128 colours in GIF, where a pixel takes a byte.
        let heads = if format == Format::Gif { 128 * 3 + 40 } else { 100 };
        assert!(each < row + heads, "{format}: {each} bytes a frame");
        assert!(each > row / 3, "{format}: {each} bytes a frame");
        // A frame that does not change at all costs next to nothing.
        let still = vec![frames[0].clone(); 40];
        let each = (film(spec(format, 24, 40), &still).0.len() - first) / 39;
        assert!(each < 120, "{format}: {each} bytes an unchanged frame");
    }
}

#[test]
fn y4m_is_its_header_and_planes() {
    let spec = FilmSpec {
        width: 3,
        height: 1,
        fps: Fps::new(30000, 1001).unwrap(),
        ..spec(Format::Y4m, 24, 2)
    };
    let frame = bytes(3, 1, 16, |x, _| [[255, 0, 0], [0, 0, 255], [200, 200, 200]][x as usize]);
    let (file, pushed) = film(spec, &[frame.clone(), frame]);
    assert_eq!(pushed[1].stored.width, 3);
    assert!(!pushed[1].changed);
    let mut want = b"YUV4MPEG2 W3 H1 F30000:1001 Ip A1:1 C444 XCOLORRANGE=FULL\n".to_vec();
    for _ in 0..2 {
        want.extend_from_slice(b"FRAME\n");
        // Red: 76.245; (0 - 76.245)/1.772 + 128 = 84.97; 255.5, which is 255. Blue: 29.07; 255.5;
        // (0 - 29.07)/1.402 + 128 = 107.26.
        want.extend_from_slice(&[76, 29, 200, 85, 255, 128, 255, 107, 128]);
    }
    assert_eq!(file, want);
}

#[test]
fn frames_must_be_as_announced() {
    let frame = bytes(WIDTH, HEIGHT, 16, |_, _| [0; 3]);
    let other = bytes(HEIGHT, WIDTH, 16, |_, _| [0; 3]);
    for format in [Format::Gif, Format::Apng, Format::Y4m] {
        let mut writer = FilmWriter::new(Vec::new(), spec(format, 24, 2)).unwrap();
        assert_eq!(writer.push(&other).unwrap_err().kind(), ErrorKind::InvalidInput);
        writer.push(&frame).unwrap();
        writer.push(&frame).unwrap();
        assert_eq!(writer.push(&frame).unwrap_err().kind(), ErrorKind::InvalidInput);
        assert_eq!(writer.frames(), 2);
        writer.finish().unwrap();
        let mut short = FilmWriter::new(Vec::new(), spec(format, 24, 2)).unwrap();
        short.push(&frame).unwrap();
        assert_eq!(short.finish().unwrap_err().kind(), ErrorKind::InvalidInput);
        assert!(FilmWriter::new(Vec::new(), spec(format, 24, 0)).is_err());
        let wide = FilmSpec { width: 65536, ..spec(format, 24, 1) };
        assert!(FilmWriter::new(Vec::new(), wide).is_err());
    }
    assert!(FilmWriter::new(Vec::new(), spec(Format::Png, 24, 1)).is_err());
}

/// What waits for the palette is in the folder that is named, and not in memory.
#[test]
fn a_long_gif_waits_in_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    let (width, height) = (400, 300);
    let draw = |seed| {
        bytes(width, height, 16, move |x, y| {
            noise(x, y, seed).to_le_bytes()[..3].try_into().unwrap()
        })
    };
    let write = |spool: Option<PathBuf>| {
        let spec = FilmSpec { width, height, spool, ..spec(Format::Gif, 24, 5) };
        let mut writer = FilmWriter::new(Vec::new(), spec)?;
        (0..5).try_for_each(|seed| writer.push(&draw(seed)).map(drop))?;
        writer.finish()
    };
    let film = write(Some(folder.path().to_owned())).unwrap();
    assert!(film == write(None).unwrap());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "the file has no name");
    let gone = folder.path().join("gone");
    let error = write(Some(gone.clone())).unwrap_err();
    assert!(error.to_string().contains(&gone.display().to_string()), "{error}");
}

/// The texts of a film, and one flipped bit anywhere in it or in what stands beside it.
#[test]
fn films_know_their_texts_and_whether_they_are_whole() {
    let folder = tempfile::tempdir().unwrap();
    let frames = wandering();
    let texts = [("Software", "a program 1.2"), ("made-from", "a: b")];
    for format in [Format::Gif, Format::Apng, Format::Webp, Format::Y4m] {
        let path = folder.path().join(format!("f.{format}"));
        let target = Target::parse(path.as_os_str(), None, 6).unwrap();
        let write = |texts: &[(&str, &str)]| {
            let sink = FilmSink::open(&target, VideoQuality::default(), Transfer::Srgb).unwrap();
            let spool = Some(folder.path().to_owned());
            let spec = FilmSpec { spool, ..spec(format, 24, 6) };
            let mut writer = FilmWriter::new(sink, spec).unwrap();
            for frame in &frames {
                writer.push(frame).unwrap();
            }
            let length = writer.commit(texts).unwrap();
            let bytes = std::fs::read(&path).unwrap();
            assert_eq!(length, bytes.len() as u64, "{format}");
            bytes
        };
        let bare = write(&[]);
        assert!(matches!(read_sealed(&path), Err(Unsealed::Bare)), "{format}");
        let manifest = manifest_path(&path);
        assert!(!manifest.exists());
        let good = write(&texts);
        let want: Vec<(String, String)> =
            texts.iter().map(|(key, value)| (key.to_string(), value.to_string())).collect();
        assert_eq!(read_sealed(&path).unwrap(), want, "{format}");
        assert_eq!(manifest.exists(), needs_manifest(format), "{format}");
        assert_eq!(good == bare, needs_manifest(format), "{format}");
        let holds = |what: &str| assert!(read_sealed(&path).is_err(), "{format}: {what}");
        // What is long is looked at here and there, its ends everywhere.
        let step = good.len() / 4000 + 1;
        let near = |at: &usize| at.is_multiple_of(step) || *at < 300 || *at + 600 > good.len();
        for at in (0..good.len()).filter(near) {
            let mut bad = good.clone();
            bad[at] ^= 1 << (at % 8);
            std::fs::write(&path, &bad).unwrap();
            holds(&format!("byte {at}"));
            std::fs::write(&path, &good[..at]).unwrap();
            holds(&format!("{at} bytes"));
        }
        std::fs::write(&path, [&good[..], b"\0"].concat()).unwrap();
        holds("a byte too many");
        std::fs::write(&path, &good).unwrap();
        let Ok(lines) = std::fs::read(&manifest) else { continue };
        for at in 0..lines.len() {
            let mut bad = lines.clone();
            bad[at] ^= 1 << (at % 8);
            std::fs::write(&manifest, &bad).unwrap();
            holds(&format!("byte {at} of the manifest"));
        }
        // A film that says nothing takes the lines of the one before with it.
        write(&[]);
        assert!(!manifest.exists());
    }
}

/// Takes `room` bytes, then is full.
struct Full {
    room: usize,
}

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.room == 0 {
            return Err(ErrorKind::StorageFull.into());
        }
        let taken = bytes.len().min(self.room);
        self.room -= taken;
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_sink_is_an_error_wherever_it_fills() {
    let frames = wandering();
    for format in [Format::Gif, Format::Apng, Format::Y4m] {
        let whole = film(spec(format, 24, 6), &frames).0.len();
        let write = |room| -> io::Result<()> {
            let mut writer = FilmWriter::new(Full { room }, spec(format, 24, 6))?;
            for frame in &frames {
                writer.push(frame)?;
            }
            writer.finish().map(drop)
        };
        for room in (0..whole).step_by(whole / 97 + 1).chain([whole - 1]) {
            let error = write(room).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::StorageFull, "{format} {room} of {whole}");
        }
        write(whole).unwrap();
    }
}
