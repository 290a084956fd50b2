//! What a file was made from, as it says itself.

use crate::tiles::Tile;
use reflet_film::{Compression, Dither, Format, Fps, Transfer, VideoQuality};
use reflet_pack::{Filter, SceneHash};

/// The program and its version.
pub const SOFTWARE: &str = concat!("reflet ", env!("CARGO_PKG_VERSION"));

/// All that decides a file's bytes, as the texts that it carries. Threads, instructions, re-use and
/// memory are not among them, nor is any clock, host or path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Provenance {
    scene: String,
    settings: String,
    tile: Option<String>,
}

/// The settings that decide a file's bytes beside the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileSettings {
    /// The frame.
    pub frame: u32,
    /// Width and height of the whole picture in pixels.
    pub size: [u32; 2],
    /// Samples a pixel.
    pub samples: u32,
    /// How they are spread around its centre.
    pub filter: Filter,
    /// The file's format.
    pub format: Format,
    /// How much time a smaller file was worth.
    pub compression: Compression,
    /// What integer samples went through, or would.
    pub transfer: Transfer,
}

/// The key of the program that made a file.
const SOFTWARE_KEY: &str = "Software";
/// The key of the scene's hash.
const SCENE_KEY: &str = "reflet-scene";
/// The key of the settings.
const SETTINGS_KEY: &str = "reflet-settings";
/// The key of what a part of a picture is.
const TILE_KEY: &str = "reflet-tile";

impl Provenance {
    /// Of a whole picture, or of a tile of one.
    pub fn new(scene: SceneHash, settings: FileSettings, tile: Option<&Tile>) -> Provenance {
        Provenance {
            scene: scene.to_string(),
            settings: settings.to_string(),
            tile: tile.map(Tile::to_string),
        }
    }

    /// The texts, in the order in which a file carries them.
    pub fn texts(&self) -> Vec<(&str, &str)> {
        let texts =
            [(SOFTWARE_KEY, SOFTWARE), (SCENE_KEY, &self.scene), (SETTINGS_KEY, &self.settings)];
        let tile = self.tile.as_deref().map(|tile| (TILE_KEY, tile));
        texts.into_iter().chain(tile).collect()
    }

    /// Width and height of the whole picture in pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        FileSettings::told(&self.settings).map_or([0, 0], |settings| settings.size)
    }

    /// In what a file that carries `texts` was made from something else; `None` if it was not.
    pub fn differs(&self, texts: &[(String, String)]) -> Option<String> {
        let told = |key: &str| texts.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str());
        match (told(SOFTWARE_KEY), told(SCENE_KEY), told(SETTINGS_KEY)) {
            (Some(software), Some(scene), Some(settings)) => {
                if software != SOFTWARE {
                    Some(format!("made by {software}"))
                } else if settings != self.settings {
                    Some(format!("made for {settings}"))
                } else if scene != self.scene {
                    Some("made from another scene".to_owned())
                } else if told(TILE_KEY) != self.tile.as_deref() {
                    Some("made as another part of the picture".to_owned())
                } else {
                    None
                }
            }
            _ => Some("it does not say what it was made from".to_owned()),
        }
    }

    /// What the intensities of a frame on disk are to go through, given the texts of its file.
    pub(crate) fn transfer_of(texts: &[(String, String)]) -> Option<Transfer> {
        let settings = texts.iter().find(|(key, _)| key == SETTINGS_KEY);
        settings.and_then(|(_, text)| FileSettings::told(text)).map(|settings| settings.transfer)
    }

    /// Of a frame on disk, given the texts of its file, if joining such frames to a film gives what
    /// rendering the film would: the whole of a picture of 8 bits, by this version.
    pub(crate) fn of_frame(texts: &[(String, String)]) -> Option<Provenance> {
        let told = |key: &str| texts.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str());
        let settings = told(SETTINGS_KEY)?;
        let exact =
            matches!(FileSettings::told(settings)?.format, Format::Png | Format::Ppm | Format::Qoi);
        let whole = told(SOFTWARE_KEY) == Some(SOFTWARE) && told(TILE_KEY).is_none();
        let scene = told(SCENE_KEY)?.to_owned();
        (exact && whole).then(|| Provenance { scene, settings: settings.to_owned(), tile: None })
    }

    /// What the file of a tile says of the picture that it is a part of.
    ///
    /// # Errors
    /// Why it is no such file.
    pub(crate) fn of_part(texts: &[(String, String)]) -> Result<Part, String> {
        let told = |key: &str| texts.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str());
        let software = told(SOFTWARE_KEY).unwrap_or_default();
        if software != SOFTWARE {
            return Err(format!("it was made by {software}, and this is {SOFTWARE}"));
        }
        let no_tile = || "it is no part of a picture, as --tile makes them".to_owned();
        let tile = told(TILE_KEY).and_then(Tile::told).ok_or_else(no_tile)?;
        let settings = told(SETTINGS_KEY).and_then(FileSettings::told).ok_or_else(no_tile)?;
        let scene = told(SCENE_KEY).ok_or_else(no_tile)?.to_owned();
        Ok(Part { scene, settings, tile })
    }

    /// Of the picture that parts were merged into.
    pub(crate) fn of_merged(scene: &str, settings: FileSettings) -> Provenance {
        Provenance { scene: scene.to_owned(), settings: settings.to_string(), tile: None }
    }
}

/// What a film is made from, frame by frame: one hash over the scenes and settings of all.
#[derive(Clone, Debug)]
pub struct FilmHasher {
    // Boxed: it holds almost two kilobytes.
    hasher: Box<blake3::Hasher>,
    frames: u32,
}

impl Default for FilmHasher {
    fn default() -> Self {
        let hasher = Box::new(blake3::Hasher::new_derive_key("reflet film 2"));
        FilmHasher { hasher, frames: 0 }
    }
}

impl FilmHasher {
    /// The next frame; of its settings, those of the picture count and not those of a file.
    pub fn push(&mut self, frame: &Provenance) {
        let Some(settings) = FileSettings::told(&frame.settings) else { return };
        let FileSettings { frame: index, size: [width, height], samples, .. } = settings;
        let line = format!("{} {index} {width}x{height} {samples}\n", frame.scene);
        self.hasher.update(line.as_bytes());
        self.frames += 1;
    }

    /// Of the film of all frames so far.
    pub fn film(&self, film: FilmSettings) -> Provenance {
        let FilmSettings { size: [width, height], fps, format, compression, dither, quality } =
            film;
        let (fps, per) = (fps.numerator(), fps.denominator());
        let mut settings =
            format!("frames={} size={width}x{height} fps={fps}/{per} format={format}", self.frames);
        if format == Format::Apng {
            settings += &format!(" compression={}", name(compression));
        }
        if format == Format::Gif && dither != Dither::None {
            settings += &format!(" dither={}", dither.name());
        }
        if format.is_by_ffmpeg() {
            settings += &format!(" quality={}", quality.get());
        }
        Provenance { scene: self.hasher.finalize().to_string(), settings, tile: None }
    }
}

/// The settings that decide a film's bytes beside its frames. Which ffmpeg encodes it is not among
/// them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilmSettings {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Frames a second.
    pub fps: Fps,
    /// The film's format.
    pub format: Format,
    /// How much time a smaller file was worth.
    pub compression: Compression,
    /// How a GIF stands for colours that its palette lacks.
    pub dither: Dither,
    /// How well ffmpeg encodes it.
    pub quality: VideoQuality,
}

/// A tile's file: of which picture it is a part, and which.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    pub scene: String,
    pub settings: FileSettings,
    pub tile: Tile,
}

fn name(compression: Compression) -> &'static str {
    match compression {
        Compression::Fast => "fast",
        Compression::Balanced => "balanced",
        Compression::Small => "small",
    }
}

impl std::fmt::Display for FileSettings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let FileSettings { frame, size: [width, height], samples, filter, .. } = self;
        let FileSettings { format, compression, transfer, .. } = self;
        write!(f, "frame={frame} size={width}x{height} samples={samples}")?;
        if *filter != Filter::Box {
            write!(f, " filter={}", filter.name())?;
        }
        write!(f, " format={format}")?;
        // Others know one way only.
        if matches!(format, Format::Png | Format::Png16 | Format::Exr | Format::Exr16) {
            write!(f, " compression={}", name(*compression))?;
        }
        if *transfer == Transfer::Linear {
            write!(f, " transfer=linear")?;
        }
        Ok(())
    }
}

impl FileSettings {
    fn told(text: &str) -> Option<FileSettings> {
        let value = |key: &str| {
            let words = text.split(' ').filter_map(|word| word.split_once('='));
            words.into_iter().find(|(k, _)| *k == key).map(|(_, v)| v)
        };
        let (width, height) = value("size")?.split_once('x')?;
        let all = [Compression::Fast, Compression::Balanced, Compression::Small];
        let compression = value("compression").unwrap_or("fast");
        Some(FileSettings {
            frame: value("frame")?.parse().ok()?,
            size: [width.parse().ok()?, height.parse().ok()?],
            samples: value("samples")?.parse().ok()?,
            filter: Filter::from_name(value("filter").unwrap_or(Filter::Box.name()))?,
            format: Format::from_name(value("format")?).ok()?,
            compression: all.into_iter().find(|c| name(*c) == compression)?,
            transfer: match value("transfer") {
                None => Transfer::Srgb,
                Some("linear") => Transfer::Linear,
                Some(_) => return None,
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_read_back() {
        for compression in [Compression::Fast, Compression::Balanced, Compression::Small] {
            let size = [65_535, 1];
            let format = Format::Exr;
            for filter in Filter::ALL {
                for transfer in [Transfer::Srgb, Transfer::Linear] {
                    let (frame, samples) = (7, 4);
                    let settings = FileSettings {
                        frame,
                        size,
                        samples,
                        filter,
                        format,
                        compression,
                        transfer,
                    };
                    assert_eq!(FileSettings::told(&settings.to_string()), Some(settings));
                }
            }
        }
        let filter = "frame=1 size=1x1 samples=1 filter=no format=exr";
        for bad in ["", filter, "frame=1", "frame=x size=1x1 samples=1 format=exr", "=", "size=1"] {
            assert_eq!(FileSettings::told(bad), None, "{bad}");
        }
    }
}
