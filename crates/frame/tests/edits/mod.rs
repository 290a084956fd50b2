//! Random scenes, and random edits of them.

mod meshes;

use glam::DVec3;
use reflet_pack::{Overrides, Packer, Sharing};
use reflet_scene::program::{Binary, Coordinate, Op, Unary};
use reflet_scene::{
    Attenuation, Camera, Caps, Checker, Cuboid, Cylinder, Disc, Ellipsoid, Falloff, Filter, Group,
    Image, Instance, Key, Mapping, Material, Place, Plane, PointLight, Program, Projector, Quad,
    Scene, Settings, Shader, Sphere, Spotlight, Spread, Stripes, Sun, Surface, TexelFilter,
    Texture, Textured, Tiles, Torus, Triangle,
};
use std::sync::Arc;

/// A small generator of its own: the same scenes on every machine.
pub struct Dice(pub u64);

impl Dice {
    pub fn float(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }

    pub fn range(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.float()
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.float() * n as f64) as usize
    }

    pub fn point(&mut self, r: f64) -> DVec3 {
        DVec3::new(self.range(-r, r), self.range(-r, r), self.range(-r, r))
    }

    pub fn colour(&mut self) -> DVec3 {
        DVec3::new(self.float(), self.float(), self.float())
    }

    pub fn pick(&mut self, keys: &[Key]) -> Key {
        keys[self.below(keys.len())]
    }
}

/// A scene, and what of it can be edited.
pub struct Stage {
    pub scene: Scene,
    pub packer: Packer,
    materials: Vec<Key>,
    checkers: Vec<Key>,
    /// Blocks, stripes, a texture and a shader.
    patterns: [Key; 4],
    spheres: Vec<Key>,
    flats: Vec<Key>,
    solids: Vec<Key>,
    /// What is only shown through instances.
    tower: Key,
    mesh: Key,
    /// Groups and instances.
    places: Vec<Key>,
    lights: Vec<Key>,
}

fn material(dice: &mut Dice) -> Material {
    let specular = if dice.below(2) == 0 { DVec3::ZERO } else { dice.colour() };
    Material { ambient: dice.colour() * 0.2, diffuse: dice.colour(), specular }
}

/// A small picture; some of its texels are black, which nothing shines through.
fn picture(dice: &mut Dice) -> Arc<Texture> {
    let (width, height) = (3, 2);
    let black = [0.0; 3];
    let texel = |dice: &mut Dice| dice.colour().to_array().map(|x| x as f32);
    let texels = 0..width * height;
    let texels = texels.map(|_| if dice.below(4) == 0 { black } else { texel(dice) }).collect();
    Arc::new(Texture { width, height, texels })
}

/// 0 and 1 in turn along x and the noise of a point: where it is 0, nothing is mirrored.
fn waves(frequency: f32) -> Arc<Program> {
    let ops = vec![
        Op::Coordinate(Coordinate::X),
        Op::Coordinate(Coordinate::Y),
        Op::Coordinate(Coordinate::NormalZ),
        Op::Noise([0, 1, 2]),
        Op::Constant(frequency),
        Op::Binary(Binary::Multiply, 0, 4),
        Op::Binary(Binary::Add, 5, 3),
        Op::Unary(Unary::Sin, 6),
        Op::Constant(0.0),
        Op::Binary(Binary::Max, 7, 8),
    ];
    Arc::new(Program { ops, colour: [9, 9, 3] })
}

/// A random scene.
pub fn stage(dice: &mut Dice) -> Stage {
    let mut scene = Scene::new();
    let (mut materials, mut checkers) = (Vec::new(), Vec::new());
    for _ in 0..5 {
        materials.push(scene.spawn((material(dice),)));
    }
    for _ in 0..2 {
        let (even, odd) = (dice.pick(&materials), dice.pick(&materials));
        let checker =
            Checker { even, odd, size: Tiles::Flat([dice.range(0.3, 1.0), 0.7]), xdir: DVec3::X };
        checkers.push(scene.spawn((checker,)));
    }
    let camera = Camera::LookAt {
        eye: DVec3::new(0.3, 1.5, 6.0),
        look_at: DVec3::ZERO,
        up: DVec3::Y,
        fov_degrees: 50.0,
    };
    scene.singletons.camera = Some(scene.spawn((camera,)));
    scene.singletons.image =
        Some(scene.spawn((Image { width: 41, height: 27, ..Image::default() },)));
    let settings = Settings { max_bounces: 3, ..Settings::default() };
    scene.singletons.settings = Some(scene.spawn((settings,)));
    let mut lights = Vec::new();
    for _ in 0..2 {
        let light = PointLight {
            at: dice.point(2.0) + DVec3::Y * 5.0,
            emissivity: dice.colour() * 20.0,
            falloff: Falloff::Inverse,
        };
        lights.push(scene.spawn((light,)));
    }
    let spot = Spotlight {
        at: DVec3::new(0.0, 6.0, 1.0),
        aim: DVec3::ZERO,
        angle_degrees: 30.0,
        emissivity: DVec3::splat(10.0),
        falloff: Falloff::Square,
    };
    lights.push(scene.spawn((spot,)));
    let sun = Sun { direction: DVec3::new(0.3, -1.0, -0.4), emissivity: dice.colour() };
    lights.push(scene.spawn((sun,)));
    let wear = |dice: &mut Dice| Surface { material: Some(dice.pick(&materials)), visible: true };
    let (mut spheres, mut flats) = (Vec::new(), Vec::new());
    for _ in 0..2 + dice.below(30) {
        let sphere = Sphere { center: dice.point(2.5), radius: dice.range(0.2, 0.8) };
        spheres.push(scene.spawn((sphere, wear(dice))));
    }
    let floor = Plane { point: DVec3::new(0.0, -2.0, 0.0), normal: DVec3::Y };
    let tiled = Surface { material: Some(checkers[0]), visible: true };
    flats.push(scene.spawn((floor, tiled)));
    let corner = dice.point(1.0) - DVec3::Z * 3.0;
    let wall = Quad { corner, u: DVec3::X * 2.0, v: DVec3::new(0.0, 2.0, 0.3) };
    flats.push(scene.spawn((wall, Surface { material: Some(checkers[1]), visible: true })));
    let blocks = Checker {
        even: dice.pick(&materials),
        odd: dice.pick(&materials),
        size: Tiles::Solid([0.4, 0.3, 0.5]),
        xdir: DVec3::X,
    };
    let stripes = Stripes {
        even: dice.pick(&materials),
        odd: dice.pick(&materials),
        width: 0.3,
        xdir: DVec3::new(1.0, 0.5, 0.2),
    };
    let textured = Textured {
        base: dice.pick(&materials),
        image: picture(dice),
        mode: Mapping::Fit,
        size: [1.0, 1.0],
        xdir: DVec3::X,
        filter: [TexelFilter::Bilinear, TexelFilter::Nearest][dice.below(2)],
    };
    let shader = Shader {
        base: dice.pick(&materials),
        ambient: None,
        diffuse: Some(waves(2.0)),
        specular: (dice.below(2) == 0).then(|| waves(3.0)),
    };
    let patterns = [
        scene.spawn((blocks,)),
        scene.spawn((stripes,)),
        scene.spawn((textured,)),
        scene.spawn((shader,)),
    ];
    let projector = Projector {
        at: dice.point(1.0) + DVec3::new(0.0, 3.0, 5.0),
        aim: DVec3::ZERO,
        up: DVec3::Y,
        angle_degrees: 25.0,
        image: picture(dice),
        emissivity: DVec3::splat(8.0),
        falloff: Falloff::Inverse,
    };
    lights.push(scene.spawn((projector,)));
    let flag = Triangle { a: dice.point(2.0), b: dice.point(2.0), c: dice.point(2.0) };
    flats.push(scene.spawn((flag, wear(dice))));
    let mut solids = Vec::new();
    for _ in 0..2 + dice.below(5) {
        let worn = [dice.pick(&materials), dice.pick(&patterns)][dice.below(2)];
        let surface = Surface { material: Some(worn), visible: true };
        let (at, axis) = (dice.point(2.5), dice.point(1.0) + DVec3::Y * 1.1);
        let (radius, height) = (dice.range(0.2, 0.7), dice.range(0.3, 1.0));
        let caps = if dice.below(2) == 0 { Caps::Open } else { Caps::Closed };
        solids.push(match dice.below(5) {
            0 => {
                let cuboid = Cuboid::Centered { center: at, size: DVec3::new(radius, height, 0.5) };
                scene.spawn((cuboid, surface))
            }
            1 => scene.spawn((Torus { center: at, axis, major: radius, minor: 0.15 }, surface)),
            2 => scene.spawn((Disc { center: at, normal: axis, radius }, surface)),
            3 => scene.spawn((Ellipsoid { center: at, radii: DVec3::splat(radius) }, surface)),
            _ => scene.spawn((Cylinder { base: at, axis, radius, height, caps }, surface)),
        });
    }
    // A prototype that only its copies show, in a group that moves as a whole.
    let hidden = Surface { material: Some(dice.pick(&materials)), visible: false };
    let (base, caps) = (DVec3::ZERO, Caps::Closed);
    let tower = Cylinder { base, axis: DVec3::Y, radius: 0.2, height: 0.8, caps };
    let tower = scene.spawn((tower, hidden));
    let ball = Sphere { center: DVec3::Y * 0.8, radius: 0.3 };
    let ball = scene.spawn((ball, Surface { visible: true, ..hidden }));
    let copy = scene.spawn((Place::default(), Instance { of: tower }));
    let members = [ball, copy].into();
    let place = Place { translate: dice.point(1.5), ..Place::default() };
    let group = scene.spawn((place, Group { members }));
    let scale = DVec3::new(1.0, dice.range(0.5, 2.0), 1.0);
    let place = Place { translate: dice.point(1.5), scale, ..Place::default() };
    let copies = scene.spawn((place, Instance { of: group }));
    let meshes = meshes::spawn(&mut scene, dice, &materials);
    let mut places = vec![copy, group, copies];
    places.extend(meshes.places);
    scene.seal();
    let sharing = [Sharing::Never, Sharing::Always][dice.below(2)];
    let packer = Packer::sharing(&scene, Overrides::default(), sharing).expect("a camera");
    Stage {
        scene,
        packer,
        materials,
        checkers,
        patterns,
        spheres,
        flats,
        solids,
        tower,
        mesh: meshes.mesh,
        places,
        lights,
    }
}

/// How many kinds of edits there are.
pub const EDITS: usize = 32;

/// Edits a scene as a frame function would.
pub fn edit(kind: usize, stage: &mut Stage, dice: &mut Dice) {
    let s = &mut stage.scene;
    match kind {
        0 => {
            let key = dice.pick(&stage.materials);
            let new = material(dice);
            s.set(key, new);
        }
        1 => {
            let key = dice.pick(&stage.materials);
            let mut m: Material = s.get(key).expect("a material");
            m.specular *= 0.5;
            s.set(key, m);
        }
        2 => {
            let key = dice.pick(&stage.lights[..2]);
            let mut l: PointLight = s.get(key).expect("a light");
            l.emissivity = dice.colour() * 20.0;
            s.set(key, l);
        }
        3 => {
            let key = dice.pick(&stage.lights[..2]);
            let mut l: PointLight = s.get(key).expect("a light");
            l.at += dice.point(1.0);
            s.set(key, l);
        }
        4 => {
            let mut l: Spotlight = s.get(stage.lights[2]).expect("a spotlight");
            l.angle_degrees = dice.range(10.0, 60.0);
            s.set(stage.lights[2], l);
        }
        5 => {
            let key = dice.pick(&stage.spheres);
            let mut ball: Sphere = s.get(key).expect("a sphere");
            ball.center += dice.point(0.4);
            s.set(key, ball);
        }
        6 => {
            let key = dice.pick(&stage.spheres);
            let mut ball: Sphere = s.get(key).expect("a sphere");
            ball.radius *= dice.range(0.5, 1.5);
            s.set(key, ball);
        }
        7 => {
            let key = if dice.below(2) == 0 {
                dice.pick(&stage.spheres)
            } else {
                dice.pick(&stage.flats)
            };
            let mut worn: Surface = s.get(key).expect("a surface");
            worn.visible = !worn.visible;
            s.set(key, worn);
        }
        8 => {
            let key = dice.pick(&stage.spheres);
            let material = Some(dice.pick(&stage.materials));
            s.set(key, Surface { material, visible: true });
        }
        9 => {
            let key = dice.pick(&stage.checkers);
            let mut c: Checker = s.get(key).expect("a checker");
            c.size = Tiles::Flat([dice.range(0.3, 1.2), 0.7]);
            s.set(key, c);
        }
        10 => {
            let mut quad: Quad = s.get(stage.flats[1]).expect("a quad");
            quad.corner += dice.point(0.4);
            s.set(stage.flats[1], quad);
        }
        11 => {
            let key = s.singletons.settings.expect("settings");
            let mut settings = s.settings();
            settings.max_bounces = dice.below(6) as u32;
            settings.max_path =
                if dice.below(2) == 0 { f64::INFINITY } else { dice.range(4.0, 12.0) };
            s.set(key, settings);
        }
        12 => {
            let key = s.singletons.settings.expect("settings");
            let mut settings = s.settings();
            settings.background = dice.colour();
            settings.attenuation =
                if dice.below(2) == 0 { Attenuation::None } else { Attenuation::Inverse };
            s.set(key, settings);
        }
        13 => {
            let key = s.singletons.image.expect("an image");
            // Half of the time a box, so that the number of samples also changes under one filter.
            let filter = Filter::ALL[dice.below(4).saturating_sub(1)];
            let samples = 1 + dice.below(3) as u32;
            let spread = [Spread::Everywhere, Spread::Edges][dice.below(2)];
            s.set(key, Image { samples, spread, filter, ..s.image() });
        }
        14 => {
            // Surfaces and a light that live for one frame.
            let made = s.spawn((material(dice),));
            for _ in 0..1 + dice.below(2) {
                let sphere = Sphere { center: dice.point(2.0), radius: 0.4 };
                s.spawn((sphere, Surface { material: Some(made), visible: true }));
            }
            s.spawn((PointLight {
                at: dice.point(4.0),
                emissivity: DVec3::splat(9.0),
                falloff: Falloff::Inverse,
            },));
            if dice.below(2) == 0 {
                // It follows what it is an instance of, which may move in the same frame.
                let place = Place { translate: dice.point(1.0), ..Place::default() };
                s.spawn((place, Instance { of: dice.pick(&stage.spheres) }));
            }
            if dice.below(2) == 0 {
                let key = dice.pick(&stage.spheres);
                s.set(key, Surface { material: Some(made), visible: true });
            }
        }
        15 => {
            let key = s.singletons.camera.expect("a camera");
            let eye = DVec3::new(0.3, 1.5, 6.0) + dice.point(0.2);
            let (look_at, up) = (DVec3::ZERO, DVec3::Y);
            s.set(key, Camera::LookAt { eye, look_at, up, fov_degrees: 50.0 });
        }
        17 => {
            let key = dice.pick(&stage.places);
            let mut place: Place = s.get(key).expect("a place");
            place.translate += dice.point(0.4);
            place.rotate.y += dice.range(0.0, 40.0);
            s.set(key, place);
        }
        18 => {
            // From a sphere to an ellipsoid and back: the rows are of another kind.
            let key = dice.pick(&stage.places);
            let mut place: Place = s.get(key).expect("a place");
            place.scale = DVec3::new(1.0, if dice.below(2) == 0 { 1.0 } else { 1.5 }, 1.0);
            s.set(key, place);
        }
        19 => {
            let key = dice.pick(&stage.places);
            let mut place: Place = s.get(key).expect("a place");
            place.visible = !place.visible;
            s.set(key, place);
        }
        20 => {
            let mut tower: Cylinder = s.get(stage.tower).expect("a cylinder");
            tower.height = dice.range(0.3, 1.2);
            tower.caps = if dice.below(2) == 0 { Caps::Open } else { Caps::Closed };
            s.set(stage.tower, tower);
        }
        21 => {
            let key = dice.pick(&stage.solids);
            if let Some(mut torus) = s.get::<Torus>(key) {
                torus.center += dice.point(0.4);
                s.set(key, torus);
            } else if let Some(Cuboid::Centered { center, size }) = s.get(key) {
                s.set(key, Cuboid::Centered { center: center + dice.point(0.3), size });
            } else if let Some(mut cylinder) = s.get::<Cylinder>(key) {
                cylinder.radius *= dice.range(0.6, 1.5);
                s.set(key, cylinder);
            } else if let Some(mut disc) = s.get::<Disc>(key) {
                disc.normal += dice.point(0.3);
                s.set(key, disc);
            } else if let Some(mut ellipsoid) = s.get::<Ellipsoid>(key) {
                ellipsoid.radii.y *= dice.range(0.5, 1.5);
                s.set(key, ellipsoid);
            }
        }
        22 => {
            if let Some(mut stripes) = s.get::<Stripes>(stage.patterns[1]) {
                stripes.width = dice.range(0.1, 0.6);
                s.set(stage.patterns[1], stripes);
            }
            let key = dice.pick(&stage.solids);
            let material = Some(dice.pick(&stage.patterns));
            s.set(key, Surface { material, visible: true });
        }
        23 => {
            let mut sun: Sun = s.get(stage.lights[3]).expect("a sun");
            sun.direction += dice.point(0.3);
            s.set(stage.lights[3], sun);
        }
        24 => {
            let key = s.singletons.camera.expect("a camera");
            let eye = DVec3::new(0.3, 1.5, 6.0);
            let (look_at, up, height) = (DVec3::ZERO, DVec3::Y, 5.0);
            s.set(key, Camera::Parallel { eye, look_at, up, height });
        }
        25 => {
            let mut shader: Shader = s.get(stage.patterns[3]).expect("a shader");
            shader.specular = (dice.below(3) > 0).then(|| waves(dice.range(1.0, 5.0) as f32));
            s.set(stage.patterns[3], shader);
        }
        26 => {
            let mut textured: Textured = s.get(stage.patterns[2]).expect("a texture");
            textured.image = picture(dice);
            s.set(stage.patterns[2], textured);
        }
        27 => {
            let mut projector: Projector = s.get(stage.lights[4]).expect("a projector");
            if dice.below(2) == 0 {
                projector.aim += dice.point(0.5);
            } else {
                projector.emissivity = dice.colour() * 9.0;
            }
            s.set(stage.lights[4], projector);
        }
        28..32 => meshes::edit(kind - 28, s, dice, (stage.mesh, &stage.materials)),
        _ => {
            let key = dice.pick(&stage.checkers);
            let mut c: Checker = s.get(key).expect("a checker");
            c.odd = dice.pick(&stage.materials);
            s.set(key, c);
        }
    }
}
