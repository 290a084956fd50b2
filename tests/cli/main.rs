//! The binary as its users meet it: exit codes, files, events, signals.

mod checked;
mod events;
mod farmed;
mod films;
mod outputs;
mod profiled;
mod resumed;
mod room;
mod stopped;
mod usage;
mod watched;
