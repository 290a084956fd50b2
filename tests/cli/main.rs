//! The binary as its users meet it: exit codes, files, events, signals.

mod checked;
mod events;
mod farmed;
mod films;
mod full;
mod inputs;
mod names;
mod outputs;
mod profiled;
mod resumed;
mod room;
mod stages;
mod stopped;
mod together;
mod usage;
mod watched;
