//! Colours that seem to be meant in 0..255, where 1 is full.

use reflet_scene::{DVec3, Key, Material, PointLight, Projector, Scene, Settings, Spotlight, Sun};

/// What a colour is for, and so how great it may well be.
#[derive(Clone, Copy)]
enum Use {
    /// A share of light: more than a few times 1 is hardly meant.
    Share,
    /// Light of a surface, which lessens on its way, or of the background.
    Glow,
    /// Light of a lamp: 10 to 50 is usual.
    Lamp,
}

/// The colours of a scene that look like 0..255: whose they are, the key, and the colour.
pub fn find(scene: &Scene) -> Vec<(Key, &'static str, DVec3)> {
    let mut found = Vec::new();
    for key in scene.keys() {
        let mut look = |name, colour: DVec3, by| {
            if looks_like_bytes(colour, by) {
                found.push((key, name, colour));
            }
        };
        if let Some(m) = scene.get::<Material>(key) {
            look("ambient", m.ambient, Use::Glow);
            look("diffuse", m.diffuse, Use::Share);
            look("specular", m.specular, Use::Share);
        }
        if let Some(settings) = scene.get::<Settings>(key) {
            look("background", settings.background, Use::Glow);
        }
        if let Some(emissivity) = emissivity(scene, key) {
            look("emissivity", emissivity, Use::Lamp);
        }
    }
    found
}

/// The emissivity of a light.
pub fn emissivity(scene: &Scene, key: Key) -> Option<DVec3> {
    let point = || scene.get::<PointLight>(key).map(|l| l.emissivity);
    let spot = || scene.get::<Spotlight>(key).map(|l| l.emissivity);
    let sun = || scene.get::<Sun>(key).map(|l| l.emissivity);
    let projector = || scene.get::<Projector>(key).map(|l| l.emissivity);
    point().or_else(spot).or_else(sun).or_else(projector)
}

fn looks_like_bytes(colour: DVec3, by: Use) -> bool {
    let [r, g, b] = colour.to_array();
    let (most, grey) = (colour.max_element(), r == g && g == b);
    let whole = [r, g, b].iter().all(|x| *x == libm::trunc(*x));
    if !(0.0..=255.0).contains(&most) || colour.min_element() < 0.0 {
        return false;
    }
    match by {
        Use::Share => most > 4.0,
        Use::Glow => whole && (most == 255.0 || most >= 100.0 && !grey),
        Use::Lamp => whole && !grey && most >= 240.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_told_from_light() {
        let v = DVec3::new;
        for (colour, by, bytes) in [
            (v(0.8, 0.1, 0.1), Use::Share, false),
            // A mirror may amplify.
            (v(1.2, 1.2, 1.2), Use::Share, false),
            (v(200.0, 30.0, 30.0), Use::Share, true),
            (v(127.5, 0.0, 0.0), Use::Share, true),
            (v(1e6, 0.0, 0.0), Use::Share, false),
            (v(20.0, 19.0, 18.0), Use::Glow, false),
            (v(100.0, 100.0, 100.0), Use::Glow, false),
            (v(135.0, 206.0, 235.0), Use::Glow, true),
            (v(255.0, 255.0, 255.0), Use::Glow, true),
            (v(60.0, 57.0, 50.0), Use::Lamp, false),
            (v(255.0, 255.0, 255.0), Use::Lamp, false),
            (v(255.0, 244.0, 229.0), Use::Lamp, true),
        ] {
            assert_eq!(looks_like_bytes(colour, by), bytes, "{colour}");
        }
    }
}
