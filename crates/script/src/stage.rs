//! A script that has run once, and its frames.

use crate::capture::Captured;
use crate::engine::{self, Printer};
use crate::error::{ErrorKind, ScriptError};
use crate::escape;
use crate::locate::{self, Script};
use crate::messages;
use crate::meter::{Heap, Meter};
use crate::nouns::FORMS;
use crate::own_thread::{self, Broken};
use crate::params::{Parameter, Parameters};
use crate::source::{self, Source};
use crate::state::{Phase, Shared, State};
use crate::table::Role;
use crate::time::{FrameFn, Moment};
use reflet_assets::Assets;
use reflet_scene::{Instance, Key, Scene};
use rhai::{AST, Dynamic, Engine, Position};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Who is told a line of text.
pub type Told = Arc<dyn Fn(&str) + Send + Sync>;

/// How a script is run.
#[derive(Clone)]
pub struct Options {
    /// After this many of Rhai's operations a run of the script, or a frame, is ended.
    pub max_operations: u64,
    /// A run of the script, or a frame, is ended when the things that it makes, and four times
    /// the strings, arrays and maps that it holds (so that they can be copied), take more bytes.
    /// Meshes and pictures from files are not among them.
    pub max_memory: u64,
    /// The counter of a counting allocator. Without one only the memory of the process is watched
    /// (where the system tells), and the limit may be passed for some milliseconds.
    pub heap: Option<Heap>,
    /// What `--set NAME=VALUE` says, in order.
    pub sets: Vec<(String, String)>,
    /// Folders beside the script's own that its files may come from, in the order in which they are
    /// looked in.
    pub assets: Vec<PathBuf>,
    /// Where `print` and `debug` go, with the script's line; stderr by default.
    pub print: Option<Printer>,
    /// Told once if the script runs for more than two seconds; stderr by default.
    pub slow: Option<Told>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            max_operations: 1_000_000_000,
            max_memory: 1 << 30,
            heap: None,
            sets: Vec::new(),
            assets: Vec::new(),
            print: None,
            slow: None,
        }
    }
}

impl std::fmt::Debug for Options {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Options")
            .field("max_operations", &self.max_operations)
            .field("max_memory", &self.max_memory)
            .field("sets", &self.sets)
            .field("assets", &self.assets)
            .finish_non_exhaustive()
    }
}

/// Something about a script that is no error.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// What was seen and what to do, on one line.
    pub message: String,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

/// A script that has run once: its scene, its frame functions and its parameters.
pub struct Stage {
    source: Source,
    engine: Engine,
    ast: AST,
    state: Shared,
    meter: Arc<Meter>,
    options: Options,
    functions: Vec<FrameFn>,
    captured: Captured,
    /// The bytes of values that the script left to its frames.
    carried: u64,
    parameters: Vec<Parameter>,
    warnings: Vec<Warning>,
    /// Whether it was said that a frame takes long.
    told: bool,
}

impl std::fmt::Debug for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Stage")
            .field("path", &self.source.path)
            .field("parameters", &self.parameters)
            .finish_non_exhaustive()
    }
}

impl Stage {
    /// Runs a script, on a thread of its own.
    ///
    /// # Errors
    /// The script is wrong or over a limit, a `--set` does not fit it, or a file that it reads is
    /// missing or bad.
    pub fn load(source: Source, options: &Options) -> Result<Stage, ScriptError> {
        let options = options.clone();
        let root = source.path.parent().map(PathBuf::from).unwrap_or_default();
        let parameters = Parameters { sets: options.sets.clone(), seen: Vec::new() };
        let assets = Assets::new(root).with_folders(options.assets.iter().cloned());
        let meter = Arc::new(Meter::new(options.max_operations, options.max_memory, options.heap));
        let state = Shared::new(State::new(assets, parameters, meter.clone()));
        let print = options.print.clone().unwrap_or_else(|| {
            let path = source.path.clone();
            Arc::new(move |text: &str, line| eprintln!("{}:{line}: {text}", path.display()))
        });
        let engine = engine::build(&state, &meter, messages::bounded(print));
        let bare = Script { path: &source.path, text: &source.text, ast: None, engine: &engine };
        if let Some(message) = source::too_long(&source.text) {
            return Err(bare.error(ErrorKind::Script, message, Position::new(1, 1)));
        }
        let compiled_and_run = || -> Result<(AST, Captured), ScriptError> {
            // Its tree is as large as its text makes it, and no value.
            let ast = meter
                .file(|| engine::compile(&engine, &source.text))
                .map_err(|error| bare.parse_error(&error))?;
            let script = Script { ast: Some(&ast), ..bare };
            if let Some((name, at)) = escape::loop_variable(&ast) {
                let message = format!(
                    "a closure that outlives its turn of the loop captures the `for` variable `{name}`, and would see its last value: write let k = {name}; in the loop, and use k"
                );
                return Err(script.error(ErrorKind::Script, message, at));
            }
            let mut scope = engine::scope();
            let ended = engine.run_ast_with_scope(&mut scope, &ast);
            let result = match ended {
                Ok(()) => finish(&script, &state, &ast, &scope),
                Err(error) => Err(script.run_error(&error)),
            };
            result.map(|captured| (ast, captured))
        };
        let run = || {
            let result = compiled_and_run();
            if result.is_err() {
                // They may hold what only this thread's stack is large enough to drop.
                drop(std::mem::take(&mut state.lock().frame_functions));
            }
            result
        };
        let slow = || tell_slow(&options, &source);
        let (ast, captured) = own_thread::run(&meter, 0, slow, run)
            .unwrap_or_else(|broken| Err(broken_down(&source.path, broken)))?;
        let carried = meter.values();
        let (functions, parameters, warnings) = {
            let mut state = state.lock();
            let functions = std::mem::take(&mut state.frame_functions);
            (functions, state.parameters.seen.clone(), warnings(&state))
        };
        Ok(Stage {
            source,
            engine,
            ast,
            state,
            meter,
            options,
            functions,
            captured,
            carried,
            parameters,
            warnings,
            told: false,
        })
    }

    /// Lets `f` read the scene as it stands: the script's own, or that of the last frame.
    pub fn with_scene<R>(&self, f: impl FnOnce(&Scene) -> R) -> R {
        f(&self.state.lock().scene)
    }

    /// Makes the scene that of a frame, whatever it was before.
    ///
    /// Frames may be asked for in any order: each starts from what the script left.
    ///
    /// # Errors
    /// A frame function is wrong or over a limit; the scene is then the script's own again.
    pub fn frame(&mut self, index: u32) -> Result<(), ScriptError> {
        self.rewind();
        if self.functions.is_empty() {
            return Ok(());
        }
        let Stage { source, engine, ast, state, meter, options, functions, captured, .. } = self;
        let (told, carried) = (&mut self.told, self.carried);
        let script = Script { path: &source.path, text: &source.text, ast: Some(ast), engine };
        let moment = {
            let mut state = state.lock();
            state.epoch += 1;
            state.phase = Phase::Frame;
            Moment { index, animation: state.scene.animation() }
        };
        let run = || -> Result<(), ScriptError> {
            let ended = functions.iter().try_for_each(|function| {
                function.call(engine, moment).map_err(|error| script.run_error(&error))
            });
            // Here, where the stack is large: what the frame left may be nested deeply.
            captured.restore();
            ended?;
            state.lock().check_written().map_err(|trouble| script.trouble(&trouble, Position::NONE))
        };
        let slow = || {
            if !std::mem::replace(told, true) {
                tell_slow(options, source);
            }
        };
        let result = own_thread::run(meter, carried, slow, run)
            .unwrap_or_else(|broken| Err(broken_down(&source.path, broken)));
        {
            let mut state = self.state.lock();
            state.phase = Phase::Script;
            self.warnings = warnings(&state);
        }
        if let Err(mut error) = result {
            self.rewind();
            error.frame = Some(index);
            return Err(error);
        }
        Ok(())
    }

    /// Makes the scene the script's own again.
    pub fn rewind(&mut self) {
        self.state.lock().rewind();
    }

    /// The parameters, in the order of their `param` calls.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// What was seen so far that is no error: no light, degrees given to `sin`, triangles without
    /// area.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// What to call an entity: its maker, and where that was called.
    pub fn name_of(&self, key: Key) -> String {
        let state = self.state.lock();
        let form = FORMS.iter().find(|form| {
            let is = form.get(&state.scene, key, 0).is_some();
            is && (form.role() == Role::Instance || !state.scene.has::<Instance>(key))
        });
        let maker = form.map_or("thing", |form| form.maker());
        match state.origins.place(key) {
            Some(place) => format!("{maker} ({place})"),
            None => maker.to_owned(),
        }
    }

    /// The files that the script asked for so far, the script itself first: what to watch.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let mut files = vec![self.source.path.clone()];
        files.extend(self.state.lock().assets.asked());
        files
    }

    /// The script.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// Whether any function was registered with `on_frame`.
    pub fn has_frame_functions(&self) -> bool {
        !self.functions.is_empty()
    }

    /// The operations that the last run of the script, or the last frame, took.
    pub fn operations(&self) -> u64 {
        self.meter.operations()
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        // A chain of closures is dropped by recursion, and this thread's stack may be small.
        let held = (std::mem::take(&mut self.functions), std::mem::take(&mut self.captured));
        if !held.0.is_empty() {
            let _ = own_thread::run(&self.meter, 0, || {}, move || drop(held));
        }
    }
}

/// Checks what holds only when the whole script has run, and seals the scene.
fn finish(
    script: &Script<'_>,
    state: &Shared,
    ast: &AST,
    scope: &rhai::Scope<'_>,
) -> Result<Captured, ScriptError> {
    let mut state = state.lock();
    state.check_written().map_err(|trouble| script.trouble(&trouble, Position::NONE))?;
    if let Some(message) = state.parameters.unknown_set() {
        return Err(script.error(ErrorKind::Set, message, Position::NONE));
    }
    if state.scene.singletons.camera.is_none() {
        let message =
            "the scene has no camera: add camera(#{ eye: [0, 2, 8], look_at: [0, 1, 0] })";
        return Err(script.error(ErrorKind::Script, message.into(), Position::NONE));
    }
    // Values nested too deep are an error even where no frame function holds them: dropping or
    // copying them could overflow the stack later.
    for (name, _, value) in scope.iter_raw() {
        Captured::walk(ast, std::iter::once(value))
            .map_err(|trouble| script.trouble(&trouble, locate::definition(ast, name)))?;
    }
    let roots: Vec<Dynamic> = state.frame_functions.iter().flat_map(FrameFn::roots).collect();
    let place = state.frame_functions.first().map_or(Position::NONE, FrameFn::place);
    let captured =
        Captured::walk(ast, roots.iter()).map_err(|trouble| script.trouble(&trouble, place))?;
    // The values are kept beside their cells, to be put back after each frame.
    if state.meter.room(0).is_err() {
        return Err(script.trouble(&state.meter.memory_trouble(), place));
    }
    state.seal();
    Ok(captured)
}

fn warnings(state: &State) -> Vec<Warning> {
    let mut warnings: Vec<Warning> = Vec::new();
    if !state.lit {
        let message = "the script makes no light: only ambient colours and the background show";
        warnings.push(Warning { message: message.into() });
    }
    warnings.extend(state.angles.warnings().map(|message| Warning { message }));
    warnings.extend(state.assets.notes().iter().map(|n| Warning { message: n.to_string() }));
    warnings
}

fn tell_slow(options: &Options, source: &Source) {
    let message = format!(
        "{}: the script runs for more than two seconds; Ctrl-C stops it, and --max-operations (now {}) bounds it",
        source.path.display(),
        options.max_operations
    );
    match &options.slow {
        Some(told) => told(&message),
        None => eprintln!("{message}"),
    }
}

fn broken_down(path: &Path, broken: Broken) -> ScriptError {
    match broken {
        Broken::NoThread => nowhere(
            path,
            ErrorKind::System,
            "the system gives no thread to run the script on: more processes or memory are needed (ulimit -u, ulimit -v)".into(),
        ),
        Broken::Panicked => {
            nowhere(path, ErrorKind::Script, "the script's thread broke down".into())
        }
    }
}

/// An error that is in no place of the script.
fn nowhere(path: &Path, kind: ErrorKind, message: String) -> ScriptError {
    ScriptError { kind, message, path: path.into(), place: None, notes: Vec::new(), frame: None }
}
