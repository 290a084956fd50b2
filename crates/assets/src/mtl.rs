//! Wavefront MTL: the materials that an OBJ file names.
//!
//! Source: "The Wavefront material (.mtl) file", Alias|Wavefront, 1995. `Ka`, `Kd` and `Ks` are read
//! as colours (one number means grey); the other statements are ignored. A colour that is not given
//! is black.

use crate::error::Fault;
use crate::words::{Words, number};
use reflet_scene::MeshMaterial;

/// The materials in the text of an MTL file, in its order.
///
/// # Errors
/// Broken or non-finite numbers, and colours before the first `newmtl`, each with its line.
pub fn parse(text: &[u8]) -> Result<Vec<MeshMaterial>, Fault> {
    let mut words = Words::of(text);
    let mut materials: Vec<MeshMaterial> = Vec::new();
    while !words.is_empty() {
        match words.next() {
            Some(b"newmtl") => {
                let black = [0.0; 3];
                let name = words.rest();
                materials.push(MeshMaterial {
                    name,
                    ambient: black,
                    diffuse: black,
                    specular: black,
                    maps: None,
                });
            }
            Some(word @ (b"Ka" | b"Kd" | b"Ks")) => {
                let statement = std::str::from_utf8(word).unwrap_or_default();
                let line = words.line;
                let Some(material) = materials.last_mut() else {
                    let message = format!("`{statement}` stands before the first `newmtl`");
                    return Err(Fault::line(line, message));
                };
                if let Some(colour) = colour(&mut words, statement)? {
                    *match statement {
                        "Ka" => &mut material.ambient,
                        "Kd" => &mut material.diffuse,
                        _ => &mut material.specular,
                    } = colour;
                }
            }
            _ => {}
        }
        words.next_line();
    }
    Ok(materials)
}

/// Three numbers, or one for a grey; `None` for a colour told otherwise, as a spectrum.
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
        1 => Ok(Some([colour[0]; 3])),
        3 => Ok(Some(colour)),
        _ => {
            let message = format!("a colour is three numbers, or one; mend the `{statement}` line");
            Err(Fault::line(words.line, message))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_by_name() {
        let text = "# x\nnewmtl red paint\nNs 10\nKd 0.75 0 0.25\nKa 0.5\n\nnewmtl b\nKs 1 1 1\n\
                    Kd spectral file.rfl\nmap_Kd a.png\n";
        let materials = parse(text.as_bytes()).unwrap();
        let names: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["red paint", "b"]);
        assert_eq!(materials[0].diffuse, [0.75, 0.0, 0.25]);
        assert_eq!(materials[0].ambient, [0.5; 3]);
        assert_eq!((materials[0].specular, materials[1].specular), ([0.0; 3], [1.0; 3]));
        assert_eq!(materials[1].diffuse, [0.0; 3]);
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
