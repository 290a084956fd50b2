//! Wavefront MTL: the materials that an OBJ file names.
//!
//! Source: "The Wavefront material (.mtl) file", Alias|Wavefront, 1995, and "Extending the Wavefront
//! MTL format for physically-based rendering", Clara.io, 2014. [`parse`] reads what a file says;
//! `worn` turns it into what a mesh wears.

pub(crate) mod worn;

use crate::error::Fault;
use crate::words::{Words, number};

/// A material as an MTL file describes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Described {
    /// What an OBJ file calls it.
    pub name: String,
    /// The colours `Ka`, `Kd`, `Ks` and `Ke`, where they are given.
    pub colours: [Option<[f64; 3]>; 4],
    /// Their textures.
    pub maps: [Option<Image>; 4],
    /// How it is lit: from 3 on it mirrors.
    pub illum: Option<u32>,
    /// `Pm`.
    pub metalness: Option<f64>,
    /// `Pr`.
    pub roughness: Option<f64>,
    /// The first words of statements that are not read, in their order.
    pub not_read: Vec<String>,
}

/// Places in [`Described::colours`] and [`Described::maps`].
pub const KA: usize = 0;
/// Diffuse.
pub const KD: usize = 1;
/// Specular.
pub const KS: usize = 2;
/// Emitted.
pub const KE: usize = 3;

/// A texture, and how it lies.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The file, as it is written.
    pub file: String,
    /// What texture coordinates are multiplied with.
    pub scale: [f64; 2],
    /// What is then added to them.
    pub offset: [f64; 2],
    /// Whether it ends at its edges.
    pub is_clamped: bool,
}

/// The materials in the text of an MTL file, in its order.
///
/// # Errors
/// Broken numbers, and colours before the first `newmtl`, each with its line.
pub fn parse(text: &[u8]) -> Result<Vec<Described>, Fault> {
    let mut words = Words::of(text);
    let mut materials: Vec<Described> = Vec::new();
    while !words.is_empty() {
        match words.next() {
            Some(b"newmtl") => {
                materials.push(Described { name: words.rest(), ..Described::default() });
            }
            Some(word) => {
                let statement = String::from_utf8_lossy(word);
                match materials.last_mut() {
                    Some(material) => material.statement(&statement, &mut words)?,
                    None if colour_of(&statement).is_some() => {
                        let message = format!("`{statement}` stands before the first `newmtl`");
                        return Err(Fault::line(words.line, message));
                    }
                    None => {}
                }
            }
            None => {}
        }
        words.next_line();
    }
    Ok(materials)
}

fn colour_of(statement: &str) -> Option<usize> {
    ["Ka", "Kd", "Ks", "Ke"].iter().position(|name| *name == statement)
}

fn map_of(statement: &str) -> Option<usize> {
    match statement.to_ascii_lowercase().as_str() {
        "map_ka" => Some(KA),
        "map_kd" => Some(KD),
        "map_ks" => Some(KS),
        "map_ke" | "map_emissive" => Some(KE),
        _ => None,
    }
}

impl Described {
    fn statement(&mut self, statement: &str, words: &mut Words<'_>) -> Result<(), Fault> {
        if let Some(slot) = colour_of(statement) {
            match colour(words, statement)? {
                Some(colour) => self.colours[slot] = Some(colour),
                None => self.pass_over(statement),
            }
            return Ok(());
        }
        if let Some(slot) = map_of(statement) {
            match Image::of(&words.rest()) {
                Some((image, odd)) => {
                    self.maps[slot] = Some(image);
                    odd.iter().for_each(|option| self.pass_over(&format!("{statement} {option}")));
                }
                None => self.pass_over(statement),
            }
            return Ok(());
        }
        match statement {
            "illum" => {
                let value = words.number(statement, "a way of lighting")?;
                self.illum = value.is_finite().then_some(value.max(0.0) as u32);
            }
            "Pm" => self.metalness = share(words, statement)?,
            "Pr" => self.roughness = share(words, statement)?,
            // Opaque.
            "d" if value(words)? == Some(1.0) => {}
            "Tr" if value(words)? == Some(0.0) => {}
            // How wide a highlight is and how light is bent: without those they say nothing.
            "Ns" | "Ni" | "sharpness" => {}
            _ => self.pass_over(statement),
        }
        Ok(())
    }

    fn pass_over(&mut self, statement: &str) {
        // Few statements are known, and no more words than those are worth a mention.
        if self.not_read.len() < 32 && !self.not_read.iter().any(|known| known == statement) {
            self.not_read.push(statement.to_owned());
        }
    }
}

/// The next number, if the next word is one.
fn value(words: &mut Words<'_>) -> Result<Option<f32>, Fault> {
    Ok(words.next().and_then(|word| number(word, words.line, "").ok()))
}

/// A share, from 0 to 1.
fn share(words: &mut Words<'_>, statement: &str) -> Result<Option<f64>, Fault> {
    let value = words.number(statement, "a share")?;
    Ok(value.is_finite().then(|| f64::from(value).clamp(0.0, 1.0)))
}

/// Three numbers, or one for a grey; `None` for a colour told otherwise, as a spectrum, or one that is
/// not finite.
fn colour(words: &mut Words<'_>, statement: &str) -> Result<Option<[f64; 3]>, Fault> {
    let mut colour = [0.0; 3];
    let mut count = 0;
    while let Some(word) = words.next() {
        if count == 0 && matches!(word, b"spectral" | b"xyz") {
            return Ok(None);
        }
        let value = number(word, words.line, statement)?;
        if let Some(slot) = colour.get_mut(count) {
            *slot = f64::from(value);
        }
        count += 1;
    }
    match count {
        1 => Ok(colour[0].is_finite().then_some([colour[0]; 3])),
        // A fourth number is an opacity that some programs add.
        3 | 4 => Ok(colour.iter().all(|x| x.is_finite()).then_some(colour)),
        _ => {
            let message = format!("a colour is three numbers, or one; mend the `{statement}` line");
            Err(Fault::line(words.line, message))
        }
    }
}

impl Image {
    /// What a map statement says after its first word, and the options that are not read. `None`: it
    /// names no file.
    fn of(line: &str) -> Option<(Image, Vec<String>)> {
        let mut image =
            Image { file: String::new(), scale: [1.0; 2], offset: [0.0; 2], is_clamped: false };
        let mut odd = Vec::new();
        let mut rest = line.trim();
        // An option is one of the format's: a file's name may begin with a hyphen.
        while let Some((option, most)) = option_of(rest) {
            rest = after_word(rest);
            let mut numbers = Vec::new();
            let mut word = "";
            for _ in 0..most {
                word = rest.split_whitespace().next().unwrap_or_default();
                let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
                // `-s`, `-o` and `-t` may have fewer numbers than three.
                if number.is_none() && most == 3 {
                    break;
                }
                numbers.extend(number);
                rest = after_word(rest);
            }
            let pair = |default: f64| [0, 1].map(|k| numbers.get(k).copied().unwrap_or(default));
            match option {
                "-s" => image.scale = pair(1.0),
                "-o" => image.offset = pair(0.0),
                "-clamp" => image.is_clamped = word.eq_ignore_ascii_case("on"),
                // How textures are blurred and stored, and of which channel a number is.
                "-blendu" | "-blendv" | "-boost" | "-texres" | "-imfchan" | "-bm" => {}
                "-mm" if numbers == [0.0, 1.0] => {}
                "-t" if numbers.iter().all(|x| *x == 0.0) => {}
                "-cc" if word.eq_ignore_ascii_case("off") => {}
                _ => odd.push(option.to_owned()),
            }
        }
        let quoted = rest.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
        rest.clone_into(&mut image.file);
        if let Some(quoted) = quoted {
            quoted.clone_into(&mut image.file);
        }
        (!image.file.is_empty()).then_some((image, odd))
    }
}

/// The option that a text begins with, and how many words follow it at most.
fn option_of(text: &str) -> Option<(&'static str, usize)> {
    const OPTIONS: [(&str, usize); 13] = [
        ("-s", 3),
        ("-o", 3),
        ("-t", 3),
        ("-mm", 2),
        ("-blendu", 1),
        ("-blendv", 1),
        ("-boost", 1),
        ("-texres", 1),
        ("-clamp", 1),
        ("-bm", 1),
        ("-imfchan", 1),
        ("-type", 1),
        ("-cc", 1),
    ];
    let word = text.split_whitespace().next()?;
    OPTIONS.into_iter().find(|(option, _)| word.eq_ignore_ascii_case(option))
}

/// What follows the first word.
fn after_word(text: &str) -> &str {
    text.split_once(char::is_whitespace).map_or("", |(_, rest)| rest.trim_start())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_by_name() {
        let text = "# x\nnewmtl red paint\nNs 10\nKd 0.75 0 0.25\nKa 0.5\n\nnewmtl b\nKs 1 1 1\n\
                    Kd spectral file.rfl\nillum 3\nd 1\nTr 0.5\n";
        let materials = parse(text.as_bytes()).unwrap();
        let names: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["red paint", "b"]);
        assert_eq!(materials[0].colours, [Some([0.5; 3]), Some([0.75, 0.0, 0.25]), None, None]);
        assert_eq!(materials[1].colours, [None, None, Some([1.0; 3]), None]);
        assert_eq!((materials[0].illum, materials[1].illum), (None, Some(3)));
        assert!(materials[0].not_read.is_empty());
        assert_eq!(materials[1].not_read, ["Kd", "Tr"]);
    }

    #[test]
    fn textures_with_options_and_blanks_in_their_names() {
        let image = |line: &str| {
            let materials = parse(format!("newmtl a\n{line}\n").as_bytes()).unwrap();
            (materials[0].maps[KD].clone(), materials[0].not_read.clone())
        };
        let plain = |file: &str| Image {
            file: file.to_owned(),
            scale: [1.0; 2],
            offset: [0.0; 2],
            is_clamped: false,
        };
        assert_eq!(image("map_Kd a.png"), (Some(plain("a.png")), vec![]));
        assert_eq!(
            image("map_kd  tex\\two words.png \r"),
            (Some(plain("tex\\two words.png")), vec![])
        );
        assert_eq!(image("map_Kd \"a b.png\""), (Some(plain("a b.png")), vec![]));
        assert_eq!(image("map_Kd -bm 0.2 -imfchan r -a.png"), (Some(plain("-a.png")), vec![]));
        let (found, odd) = image("map_Kd -s 2 3 1 -o 0.5 -clamp on -blendu off -t 1 a b.png");
        let wanted =
            Image { scale: [2.0, 3.0], offset: [0.5, 0.0], is_clamped: true, ..plain("a b.png") };
        assert_eq!((found, odd), (Some(wanted), vec!["map_Kd -t".to_owned()]));
        assert_eq!(image("map_Kd"), (None, vec!["map_Kd".to_owned()]));
        assert_eq!(image("map_Kd -s 1 1"), (None, vec!["map_Kd".to_owned()]));
    }

    #[test]
    fn every_fault_has_its_line() {
        for (text, line, message) in [
            ("Kd 1 1 1", 1, "`Kd` stands before the first `newmtl`"),
            ("newmtl a\nKd 1 1\n", 2, "a colour is three numbers, or one; mend the `Kd` line"),
            ("newmtl a\nKs\n", 2, "a colour is three numbers, or one; mend the `Ks` line"),
            ("newmtl a\n\nKa 1 x 1", 3, "`x` is not a number; mend the `Ka` line"),
        ] {
            let fault = parse(text.as_bytes()).unwrap_err();
            assert_eq!((fault.line, fault.message.as_str()), (Some(line), message));
        }
    }
}
