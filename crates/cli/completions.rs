//! `reflet completions SHELL` and `reflet man [COMMAND]`: what is derived from the declaration of
//! the command line.

use crate::args::Typed;
use crate::exit::{Exit, Failure};
use clap::CommandFactory;
use clap_complete::Shell;

/// The completion script of a shell.
pub fn completions(shell: Shell) -> Vec<u8> {
    let mut out = Vec::new();
    clap_complete::generate(shell, &mut Typed::command(), "reflet", &mut out);
    out
}

/// A manual page in roff: of the whole program, or of one command.
///
/// # Errors
/// There is no such command.
pub fn man(name: Option<&str>) -> Result<Vec<u8>, Failure> {
    let mut command = Typed::command();
    command.build();
    let page = match name {
        None => command,
        Some(name) => {
            let Some(found) = command.find_subcommand(name).cloned() else {
                let known: Vec<_> =
                    command.get_subcommands().map(clap::Command::get_name).collect();
                let message =
                    format!("there is no command `{name}`; there are {}", known.join(", "));
                return Err(Failure::new(Exit::Usage, message));
            };
            found.display_name(format!("reflet-{name}"))
        }
    };
    let mut out = Vec::new();
    clap_mangen::Man::new(page).render(&mut out).map_err(|e| Failure::printing(&e))?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page_and_every_shell_a_script() {
        let main = String::from_utf8(man(None).unwrap()).unwrap();
        assert!(main.contains(".TH reflet 1"), "{main}");
        for sub in Typed::command().get_subcommands() {
            let page = String::from_utf8(man(Some(sub.get_name())).unwrap()).unwrap();
            assert!(page.contains(&format!(".TH reflet-{} 1", sub.get_name())), "{page}");
            assert!(main.contains(&format!("reflet\\-{}", sub.get_name())), "{main}");
        }
        assert_eq!(man(Some("nothing")).unwrap_err().exit, Exit::Usage);
        for shell in clap::ValueEnum::value_variants() {
            let script = String::from_utf8(completions(*shell)).unwrap();
            assert!(script.contains("max-operations"), "{shell}");
        }
    }
}
