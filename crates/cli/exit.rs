//! How the program ends: every exit code, and what leads to it.

use crate::console::Console;
use reflet_frame::RenderError;
use reflet_script::{ErrorKind, ScriptError};
use std::io;
use std::process::ExitCode;

/// The exit codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Done.
    Done = 0,
    /// Some frames failed, for a cause that has no code of its own (memory, say).
    Failed = 1,
    /// The command line is wrong; also a `--set` or `--frames` that the script does not take.
    Usage = 2,
    /// The script is wrong, at any frame.
    Script = 65,
    /// An input is missing or bad.
    Input = 66,
    /// An output could not be written.
    Output = 74,
    /// Stopped by SIGUSR1, a scheduler's warning: to be resumed.
    Resumable = 75,
    /// Stopped by SIGINT.
    Interrupted = 130,
    /// Stopped by SIGTERM.
    Terminated = 143,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(exit as u8)
    }
}

/// Why a command did not end well.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The code that the program ends with.
    pub exit: Exit,
    /// What to tell, without `error:` in front; empty if there is nobody to tell.
    pub message: String,
    /// Whether `--watch` goes on.
    pub watch: Watch,
}

/// What a failure means to `--watch`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Watch {
    /// The next save may mend it.
    GoesOn,
    /// What is written would be read, and so be rendered again without end.
    Ends,
}

impl Failure {
    /// A failure that is told.
    pub fn new(exit: Exit, message: impl Into<String>) -> Self {
        Self { exit, message: message.into(), watch: Watch::GoesOn }
    }

    /// A failure that is not told.
    pub fn quiet(exit: Exit) -> Self {
        Self::new(exit, "")
    }

    /// A wrong command line.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::new(Exit::Usage, format!("{}\n\nFor more information, try '--help'.", message.into()))
    }

    /// Text for stdout could not be printed.
    ///
    /// A reader that has seen enough (`reflet params x.rhai | head -1`) is no failure.
    pub fn printing(error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::quiet(Exit::Done),
            _ => Self::new(Exit::Output, format!("cannot write to stdout: {error}")),
        }
    }

    /// Says what is wrong on stderr, and gives the exit code.
    pub fn end(&self, console: &Console) -> ExitCode {
        console.show("");
        if !self.message.is_empty() {
            console.error(&self.message);
        }
        self.exit.into()
    }
}

impl From<ScriptError> for Failure {
    fn from(error: ScriptError) -> Self {
        let exit = match error.kind {
            ErrorKind::Script => Exit::Script,
            ErrorKind::Set => Exit::Usage,
            ErrorKind::Input => Exit::Input,
            ErrorKind::System => Exit::Failed,
        };
        Self::new(exit, error.to_string())
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Script { error, .. } => (*error).into(),
            // The reader of `-o -` has left. Not all that was asked for was delivered, so this is
            // no success; but there is nothing to tell, either.
            RenderError::Output { error, .. } if error.kind() == io::ErrorKind::BrokenPipe => {
                Self::quiet(Exit::Output)
            }
            // The message of the file's own error names the file and says what to do.
            RenderError::Output { frame, error, .. } => {
                Self::new(Exit::Output, format!("frame {frame}: {error}"))
            }
            RenderError::Refused(refusal) => {
                Self { watch: Watch::Ends, ..Self::new(Exit::Output, refusal.to_string()) }
            }
            // Who cancelled knows better; this is what stays if nobody says.
            RenderError::Cancelled => Self::new(Exit::Interrupted, "stopped"),
            RenderError::Usage(message) => Self::usage(message),
            error @ (RenderError::Memory { .. } | RenderError::Other(_)) => {
                Self::new(Exit::Failed, error.to_string())
            }
        }
    }
}
