//! The command line of Reflet: typed, meant, run, exit code.

mod args;
mod check;
mod completions;
mod console;
mod exit;
mod farm;
mod film;
mod frames;
mod heap;
mod json;
mod meant;
mod merge;
mod new;
mod params;
mod parts;
mod profile;
mod progress;
mod render;
mod shell;
mod signals;
mod told;
mod values;
mod verify;
mod watch;

use clap::Parser;
use console::{Console, print};
use exit::{Exit, Failure};
use meant::{Meant, Tell, Times};
use signals::Signals;
use std::process::ExitCode;

fn main() -> ExitCode {
    let typed = args::Typed::parse();
    let console = Console::new();
    let done = Meant::by(typed, &console).and_then(|meant| run(meant, &console));
    done.map_or_else(|failure| failure.end(&console), |()| Exit::Done.into())
}

fn run(meant: Meant, console: &Console) -> Result<(), Failure> {
    let signals = Signals::listen(console)?;
    match meant {
        Meant::Render(meant) => match meant.times {
            Times::Once => render::run(&meant, console, &signals),
            Times::AtEachSave => watch::run(&meant, console, &signals),
        },
        Meant::Profile(meant) => profile::run(&meant),
        Meant::Verify(meant) => verify::run(&meant, console, &signals),
        Meant::Merge(args) => merge::run(&args, console, &signals),
        Meant::Film(args) => film::run(&args, console, &signals),
        Meant::Farm(command) => farm::run(&command, console),
        Meant::Check(script, frames) => print(check::run(&script, frames.as_ref(), console)?),
        Meant::Params(script, tell) => {
            let stage = script.load()?;
            let form = if tell == Tell::Programs { params::json } else { params::table };
            print(form(stage.parameters()))
        }
        Meant::New(args) => print(new::run(&args)?),
        Meant::Completions(shell) => print(completions::completions(shell)),
        Meant::Man(command) => print(completions::man(command.as_deref())?),
    }
}
