//! What all native functions share: the scene, and what is known about the script's run.

use crate::angles::Angles;
use crate::handle::Handle;
use crate::meter::Meter;
use crate::nouns::{CHECKER, FORMS, MATERIAL, SHADER, STRIPES, TEXTURED};
use crate::origins::Origins;
use crate::params::Parameters;
use crate::placed::Placed;
use crate::table::{AnyForm, Kind, Role, Takes, Value, to_dynamic};
use crate::time::FrameFn;
use crate::trouble::{Fallible, Trouble, trouble};
use crate::wardrobe::Wardrobe;
use crate::{names, parse, symbolic};
use glam::DVec3;
use reflet_assets::Assets;
use reflet_scene::{
    Checker, Fault, Key, Mapped, Mapping, Material, Mesh, MeshData, MeshMaterial, Scene, Shader,
    Stripes, Surface, Textured, Tiles, Worn,
};
use rhai::{Dynamic, FnPtr, Map, NativeCallContext, Position};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Whether the script itself runs, or a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    Script,
    Frame,
}

/// The state behind every native function.
pub(crate) struct State {
    pub scene: Scene,
    pub assets: Assets,
    /// What the script takes, which the things that it makes are told from.
    pub meter: Arc<Meter>,
    pub phase: Phase,
    /// Counts the frame calls, so that a handle of an earlier one is known.
    pub epoch: u64,
    pub parameters: Parameters,
    pub frame_functions: Vec<FrameFn>,
    /// Whether the script made a light.
    pub lit: bool,
    /// Where the makers of which there is one were called.
    singles: BTreeMap<&'static str, Position>,
    /// Nouns whose relations are to be checked when the run is over, with the last write.
    pub written: BTreeMap<Key, (Kind, Position)>,
    /// Pairs of a pattern and a surface that wore it at some time.
    wearers: Vec<(Key, Key)>,
    wearers_of_script: usize,
    /// The kinds of surfaces that ever wore a pattern.
    kinds: BTreeMap<Key, Kind>,
    pub placed: Placed,
    /// The names of mesh files, by the address of their columns, which `assets` keeps alive.
    files: HashMap<usize, String>,
    pub origins: Origins,
    pub angles: Angles,
}

/// The state, shared between native functions.
#[derive(Clone)]
pub(crate) struct Shared(Arc<Mutex<State>>);

impl Shared {
    pub fn new(state: State) -> Self {
        Self(Arc::new(Mutex::new(state)))
    }

    pub fn lock(&self) -> MutexGuard<'_, State> {
        // A panic under the lock ends the whole stage; what is left is only read.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    pub fn new(assets: Assets, parameters: Parameters, meter: Arc<Meter>) -> Self {
        Self {
            scene: Scene::new(),
            assets,
            meter,
            phase: Phase::Script,
            epoch: 0,
            parameters,
            frame_functions: Vec::new(),
            lit: false,
            singles: BTreeMap::new(),
            written: BTreeMap::new(),
            wearers: Vec::new(),
            wearers_of_script: 0,
            kinds: BTreeMap::new(),
            placed: Placed::default(),
            files: HashMap::new(),
            origins: Origins::default(),
            angles: Angles::default(),
        }
    }

    /// The script has ended: what follows is undone by [`State::rewind`].
    pub fn seal(&mut self) {
        self.wearers_of_script = self.wearers.len();
        self.written.clear();
        self.scene.seal();
    }

    /// Puts everything back to what it was when the script ended.
    pub fn rewind(&mut self) {
        self.scene.rewind();
        self.wearers.truncate(self.wearers_of_script);
        let made = Key(self.scene.sealed_len());
        self.kinds.split_off(&made);
        self.placed.truncate(made);
        self.origins.truncate(made);
        self.written.clear();
    }

    /// An error if `what` may not be called in a frame.
    pub fn script_only(&self, what: &str) -> Fallible<()> {
        match self.phase {
            Phase::Script => Ok(()),
            Phase::Frame => Err(trouble(format!(
                "`{what}` cannot be called in a frame, only by the script itself"
            ))),
        }
    }

    /// What a maker does: checks the map, fills the noun, and gives it a key.
    pub fn make(&mut self, maker: &'static str, map: &Map, call: Position) -> Fallible<Handle> {
        let form = parse::choose(maker, map)?;
        if form.role().single() {
            self.script_only(maker)?;
            if let Some(first) = self.singles.get(maker) {
                let line = first.line().map_or("an earlier line".into(), |l| format!("line {l}"));
                return Err(trouble(format!(
                    "there is one `{maker}` in a scene, and the first is on {line}"
                )));
            }
        }
        let key = self.make_form(form, map, call)?;
        self.lit |= form.role() == Role::Light;
        if form.role().single() {
            self.singles.insert(maker, call);
            let singles = &mut self.scene.singletons;
            match form.role() {
                Role::Camera => singles.camera = Some(key),
                Role::Image => singles.image = Some(key),
                Role::Settings => singles.settings = Some(key),
                _ => singles.animation = Some(key),
            }
        }
        Ok(self.handle(key, Kind(form)))
    }

    /// Makes a noun of one form from its map.
    pub fn make_form(
        &mut self,
        form: &'static dyn AnyForm,
        map: &Map,
        call: Position,
    ) -> Result<Key, Trouble> {
        let mut values = parse::values(self, form, map, call)?;
        self.dress(form, &mut values);
        let wears = values.iter().find_map(|(_, v)| match v {
            Value::Wear(Some(key)) if form.role() == Role::Surface => Some(*key),
            _ => None,
        });
        let key = form
            .make(&mut self.scene, values)
            .map_err(|fault| Trouble::with_key(fault.property, fault.to_string()))?;
        self.origins.note(key, call.line().unwrap_or_default());
        if let Some(paint) = wears {
            self.note_wearer(key, Kind(form), paint);
            self.check_wearer(key, Kind(form))
                .map_err(|fault| Trouble::with_key("material", words_of_wear(&fault)))?;
        }
        self.check_uvs(key).map_err(|(name, why)| Trouble::with_key(name, why))?;
        Ok(key)
    }

    /// Gives a new mesh the materials of its file, but where it wears one as a whole or is given
    /// others.
    fn dress(&mut self, form: &'static dyn AnyForm, values: &mut Vec<(usize, Value)>) {
        let Some((at, _)) = form.find("materials") else { return };
        let (mut file, mut given, mut wears_one) = (None, Vec::new(), false);
        for (_, value) in values.iter() {
            match value {
                Value::Mesh(data) => file = Some(data.clone()),
                Value::Wardrobe(worn) => given = worn.clone(),
                value => wears_one |= matches!(value, Value::Wear(_)),
            }
        }
        if let Some(data) = file.filter(|_| !wears_one) {
            let own = self.materials_of(&data, &given);
            values.insert(0, (at, Value::Wardrobe(own)));
        }
    }

    /// Makes the materials of a mesh's file, but those that are `given`.
    fn materials_of(&mut self, data: &MeshData, given: &[Worn]) -> Vec<Worn> {
        let given: HashSet<&str> = given.iter().map(|other| &other.name[..]).collect();
        let is_given = |own: &&MeshMaterial| given.contains(&own.name[..]);
        let make = |own: &MeshMaterial| {
            let [ambient, diffuse, specular] =
                [own.ambient, own.diffuse, own.specular].map(DVec3::from_array);
            let colours = Material { ambient, diffuse, specular };
            let material = match &own.maps {
                Some(maps) => self.scene.spawn((colours, Mapped(maps.clone()))),
                None => self.scene.spawn((colours,)),
            };
            Worn { name: own.name.clone(), material }
        };
        data.materials.iter().filter(|own| !is_given(own)).map(make).collect()
    }

    /// What a surface wears that was given nothing: a mesh the one material of its file, anything
    /// else the grey matt default, as an entity of its own as soon as a script asks for it.
    fn undeclared(&mut self, surface: Key) -> Fallible<Key> {
        let mesh = self.scene.get::<Mesh>(surface);
        match mesh.as_ref().map_or(&[][..], |mesh| &mesh.worn[..]) {
            [] => {}
            [one] => return Ok(one.material),
            _ => {
                let own = mesh.iter().flat_map(|mesh| &mesh.data.materials);
                let names: Vec<&str> = own.map(|own| &own.name[..]).collect();
                return Err(trouble(format!(
                    "this mesh wears several materials, those of its file: `materials` has {}",
                    names::listed(&names)
                )));
            }
        }
        let paint = self.scene.spawn((Material::GREY_MATT,));
        if let Some(mut own) = self.scene.get::<Surface>(surface) {
            own.material = Some(paint);
            self.scene.set(surface, own);
        }
        Ok(paint)
    }

    /// The handle of a thing that was just made.
    pub fn handle(&self, key: Key, kind: Kind) -> Handle {
        let of_script = self.scene.is_sealed() && key.0 < self.scene.sealed_len();
        Handle { key, kind, epoch: if of_script { 0 } else { self.epoch } }
    }

    /// The handle of what a surface wears.
    fn paint(&self, key: Key) -> Handle {
        let form: &'static dyn AnyForm = if self.scene.has::<Checker>(key) {
            &CHECKER
        } else if self.scene.has::<Stripes>(key) {
            &STRIPES
        } else if self.scene.has::<Textured>(key) {
            &TEXTURED
        } else if self.scene.has::<Shader>(key) {
            &SHADER
        } else {
            &MATERIAL
        };
        self.handle(key, Kind(form))
    }

    /// An error if the thing was made in an earlier frame.
    pub fn alive(&self, key: Key, epoch: u64, what: &str) -> Fallible<()> {
        if epoch != 0 && epoch != self.epoch {
            return Err(trouble(format!(
                "{what} was made in an earlier frame, and is gone with it"
            )));
        }
        if key.0 >= self.scene.len() {
            return Err(trouble(format!("{what} is no more")));
        }
        Ok(())
    }

    /// Reads a property.
    pub fn get(&mut self, handle: Handle, name: &str) -> Fallible<Dynamic> {
        self.alive(handle.key, handle.epoch, &handle.kind.with_article())?;
        let Some((at, info)) = handle.kind.0.find(name) else {
            return Err(unknown_property(handle.kind, name));
        };
        let mut value = handle.kind.0.get(&self.scene, handle.key, at);
        if let Some(Value::Wear(None)) = value {
            value = Some(Value::Wear(Some(self.undeclared(handle.key)?)));
        }
        let value = value.ok_or_else(|| unknown_property(handle.kind, name))?;
        if let Value::Wardrobe(_) = value {
            return Ok(Dynamic::from(Wardrobe(handle)));
        }
        Ok(to_dynamic(value, info.takes, |key| self.paint(key), |address| self.file_of(address)))
    }

    /// Writes a property.
    pub fn set(
        &mut self,
        handle: Handle,
        name: &str,
        to: Dynamic,
        place: Position,
    ) -> Fallible<()> {
        self.alive(handle.key, handle.epoch, &handle.kind.with_article())?;
        let Handle { key, kind, .. } = handle;
        let Some((at, info)) = kind.0.find(name) else {
            return Err(unknown_property(kind, name));
        };
        let role = kind.0.role();
        if self.phase == Phase::Frame {
            let fixed = role == Role::Animation || (role == Role::Image && info.name != "samples");
            if fixed {
                return Err(trouble(format!(
                    "`{}` of {} cannot be written in a frame",
                    info.name,
                    kind.with_article()
                )));
            }
        }
        let value = parse::value(self, Kind(kind.0), info, &to, place)?;
        if let (Value::Wardrobe(to), Some(mesh)) = (&value, self.scene.get::<Mesh>(key))
            && to.iter().all(|worn| mesh.worn_by(&worn.name) == Some(worn.material))
        {
            // `car.materials.paint.diffuse = 1` writes the same map back.
            return Ok(());
        }
        if let (Value::Mesh(data), Some(mut mesh)) = (&value, self.scene.get::<Mesh>(key))
            && !Arc::ptr_eq(data, &mesh.data)
        {
            mesh.worn = [].into();
            mesh.wear(self.materials_of(data, &[]));
            self.scene.set(key, mesh);
        }
        let wear = match value {
            Value::Wear(Some(paint)) if role == Role::Surface => Some(paint),
            _ => None,
        };
        kind.0.set(&mut self.scene, key, at, value);
        if let Some(paint) = wear {
            self.note_wearer(key, kind, paint);
        }
        let concerned = kind.0.related()
            || role == Role::Pattern
            || (role == Role::Surface && wear.is_some())
            || kind.0.flat();
        if concerned {
            self.written.insert(key, (kind, place));
        }
        Ok(())
    }

    /// Remembers that a thing was written, so that it is checked once all is.
    pub fn note_written(&mut self, key: Key, kind: Kind, place: Position) {
        self.written.insert(key, (kind, place));
    }

    /// Checks the relations of everything written; the first that is wrong, with its last write.
    pub fn check_written(&mut self) -> Result<(), Trouble> {
        let written = std::mem::take(&mut self.written);
        for (&key, &(kind, place)) in &written {
            kind.0
                .check(&self.scene, key)
                .map_err(|f| Trouble::new(of_kind(kind, &f)).at(place))?;
            if kind.0.role() == Role::Surface {
                self.check_wearer(key, kind)
                    .map_err(|f| Trouble::new(words_of_wear(&f)).at(place))?;
                self.check_uvs(key).map_err(|(_, why)| Trouble::new(why).at(place))?;
            }
            if kind.0.role() == Role::Pattern {
                for &(_, surface) in self.wearers.iter().filter(|(checker, _)| *checker == key) {
                    if let Some(&kind) = self.kinds.get(&surface) {
                        self.check_wearer(surface, kind)
                            .map_err(|f| Trouble::new(words_of_wear(&f)).at(place))?;
                        self.check_uvs(surface).map_err(|(_, why)| Trouble::new(why).at(place))?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Remembers that a surface wears a pattern.
    fn note_wearer(&mut self, surface: Key, kind: Kind, paint: Key) {
        if !self.scene.has::<Material>(paint) {
            self.wearers.push((paint, surface));
            self.kinds.insert(surface, kind);
        }
    }

    /// Whether a pattern can be worn by surfaces of a kind; why not.
    pub fn suits(&self, pattern: Key, kind: Kind) -> Result<(), String> {
        let who = kind.with_article();
        if let Some(checker) = self.scene.get::<Checker>(pattern)
            && matches!(checker.size, Tiles::Flat(_))
            && !kind.0.flat()
        {
            return Err(format!(
                "{who} cannot wear a checker with two sizes, which needs a flat surface: plane, quad, triangle or disc; give it three: size: [1, 1, 1]"
            ));
        }
        match self.scene.get::<Textured>(pattern).map(|t| t.mode) {
            Some(Mapping::Tile) if !kind.0.flat() => Err(format!(
                "{who} cannot wear a texture in tiles, which needs a flat surface: plane, quad, triangle or disc; use mode: \"fit\""
            )),
            Some(Mapping::Fit) if kind.name() == "plane" => Err(format!(
                "{who} has no end that a texture could fit: use mode: \"tile\", with its size"
            )),
            _ => Ok(()),
        }
    }

    /// Whether the pattern that a surface wears (if any) suits it.
    fn check_wearer(&self, surface: Key, kind: Kind) -> Result<(), Fault> {
        let Some(paint) = self.scene.get::<Surface>(surface).and_then(|s| s.material) else {
            return Ok(());
        };
        self.suits(paint, kind).map_err(|why| Fault::new("size", why))?;
        let Some(normal) = kind.0.normal(&self.scene, surface) else { return Ok(()) };
        if let Some(checker) = self.scene.get::<Checker>(paint) {
            return checker.check_on(normal);
        }
        if let Some(textured) = self.scene.get::<Textured>(paint) {
            return textured.check_on(normal);
        }
        self.scene.get::<Stripes>(paint).map_or(Ok(()), |stripes| stripes.check_on(normal))
    }

    /// Remembers the name of a file by the address of what it holds.
    pub fn note_file(&mut self, address: usize, file: &str) {
        self.files.entry(address).or_insert_with(|| file.to_owned());
    }

    /// The name of the file that is held at an address.
    pub fn file_of(&self, address: usize) -> String {
        self.files.get(&address).cloned().unwrap_or_default()
    }
}

impl Role {
    /// Whether there is one in a scene.
    fn single(self) -> bool {
        matches!(self, Role::Camera | Role::Image | Role::Settings | Role::Animation)
    }
}

fn of_kind(kind: Kind, fault: &Fault) -> String {
    format!("`{}` of {} {}", fault.property, kind.with_article(), fault.message)
}

fn words_of_wear(fault: &Fault) -> String {
    match fault.property {
        "size" => fault.message.clone(),
        property => format!("`{property}` of the pattern {}", fault.message),
    }
}

fn unknown_property(kind: Kind, name: &str) -> Box<rhai::EvalAltResult> {
    let known: Vec<&str> = kind.0.keys().iter().map(|k| k.name).collect();
    trouble(format!("{} has no `{name}`{}", kind.with_article(), names::offer(name, "has", &known)))
}

/// What a function that is given for a key of a shader records; anything else as it is.
/// It is called before the state is locked, since it may call makers.
pub(crate) fn record_function(
    ctx: &NativeCallContext,
    form: &dyn AnyForm,
    name: &str,
    given: Dynamic,
) -> Fallible<Dynamic> {
    let expression = form.find(name).filter(|(_, info)| info.takes == Takes::Expression);
    let function = given.read_lock::<FnPtr>().map(|f| f.clone());
    match expression.zip(function) {
        Some(((_, info), function)) => {
            symbolic::record(ctx, info.name, &function).map(Dynamic::from)
        }
        None => Ok(given),
    }
}

/// Calls the functions in a shader's map, each in its place.
fn record_functions(ctx: &NativeCallContext, maker: &str, map: &mut Map) -> Fallible<()> {
    if maker != SHADER.maker {
        return Ok(());
    }
    for (name, value) in map {
        *value = record_function(ctx, &SHADER, name, std::mem::take(value))?;
    }
    Ok(())
}

/// Registers the makers.
pub(crate) fn register(engine: &mut rhai::Engine, state: &Shared) {
    let own = |f: &&&dyn AnyForm| !matches!(f.role(), Role::Group | Role::Instance);
    let mut makers: Vec<&'static str> = FORMS.iter().filter(own).map(|f| f.maker()).collect();
    makers.dedup();
    for maker in makers {
        let shared = state.clone();
        engine.register_fn(
            maker,
            move |ctx: NativeCallContext, mut map: Map| -> Fallible<Handle> {
                record_functions(&ctx, maker, &mut map)?;
                let mut state = shared.lock();
                let meter = state.meter.clone();
                meter.scene(|| state.make(maker, &map, ctx.call_position()))
            },
        );
    }
}
