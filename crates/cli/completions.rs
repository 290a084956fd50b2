//! `reflet completions SHELL` and `reflet man [COMMAND]`: what is derived from the declaration of
//! the command line.

use crate::args::Typed;
use crate::exit::{Exit, Failure};
use clap::CommandFactory;
use clap_complete::Shell;
use std::io::{self, Write};

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
    write(page).map_err(|e| Failure::printing(&e))
}

fn write(page: clap::Command) -> io::Result<Vec<u8>> {
    let examples = page.get_before_help().map(ToString::to_string);
    let codes = page.get_after_help().map(ToString::to_string);
    let commands = page.get_subcommands().next().is_some();
    let man = clap_mangen::Man::new(page);
    let mut out = Vec::new();
    man.render_title(&mut out)?;
    man.render_name_section(&mut out)?;
    man.render_synopsis_section(&mut out)?;
    man.render_description_section(&mut out)?;
    man.render_options_section(&mut out)?;
    if commands {
        man.render_subcommands_section(&mut out)?;
    }
    table(&mut out, "EXAMPLES", examples)?;
    table(&mut out, "EXIT STATUS", codes)?;
    Ok(out)
}

/// A section of lines that stay as they are; the first, a heading, is left out.
fn table(out: &mut Vec<u8>, section: &str, text: Option<String>) -> io::Result<()> {
    let Some(text) = text else { return Ok(()) };
    writeln!(out, ".SH {section}\n.nf")?;
    for line in text.lines().skip(1) {
        writeln!(out, "\\&{}", line.replace('\\', "\\\\").replace('-', "\\-"))?;
    }
    writeln!(out, ".fi")
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
            assert!(page.contains(".SH EXAMPLES\n.nf\n\\&  reflet "), "{page}");
            assert!(main.contains(&format!("reflet\\-{}", sub.get_name())), "{main}");
        }
        let commands: Vec<_> =
            Typed::command().get_subcommands().map(|c| c.get_name().to_owned()).collect();
        assert_eq!(commands, crate::values::COMMANDS, "completions of `man` know all commands");
        assert_eq!(man(Some("nothing")).unwrap_err().exit, Exit::Usage);
        for shell in clap::ValueEnum::value_variants() {
            let script = String::from_utf8(completions(*shell)).unwrap();
            assert!(script.contains("max-operations"), "{shell}");
            // Elvish's and PowerShell's know no values.
            if ["bash", "zsh", "fish"].contains(&shell.to_string().as_str()) {
                for value in ["sse4.2", "png16", "balanced", "high", "verify"] {
                    assert!(script.contains(value), "{shell}: {value}");
                }
            }
        }
    }
}
