//! `palpate completions`.

use super::Failure;
use super::output::print;
use clap::CommandFactory;

/// Print completions for a shell.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  palpate completions bash > ~/.local/share/bash-completion/completions/palpate
  palpate completions zsh > ~/.zfunc/_palpate
  palpate completions fish > ~/.config/fish/completions/palpate.fish")]
pub struct Args {
    /// The shell
    shell: clap_complete::Shell,
}

/// Prints the completions of the whole command line.
pub fn run<Whole: CommandFactory>(args: &Args) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Whole::command(), "palpate", &mut text);
    print(&String::from_utf8_lossy(&text))
}
