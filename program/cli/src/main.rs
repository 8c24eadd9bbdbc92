//! The `leafwise` program.

use std::io::{self, IsTerminal, LineWriter, Write};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use leafwise_cli::console::Console;
use leafwise_cli::failure::exit;
use leafwise_cli::interrupt;

fn main() -> ExitCode {
    let raised = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&raised);
    // The first interruption asks for a checkpoint, the second ends the program; so does the first
    // where nothing has begun.
    let handler = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) || !interrupt::is_watched() {
            let _ = writeln!(io::stderr(), "\ninterrupted");
            std::process::exit(exit::INTERRUPTED.into());
        }
        // A terminal that has gone away is no reason to die before the checkpoint.
        let _ = writeln!(io::stderr(), "\nstopping; interrupt again to end at once");
    });
    // Schedulers announce the end of a job by it.
    #[cfg(unix)]
    let announced = signal_hook::flag::register(signal_hook::consts::SIGUSR1, Arc::clone(&raised));
    let is_terminal = io::stderr().is_terminal();
    let color = is_terminal && std::env::var_os("NO_COLOR").is_none();
    // What a library prints goes to standard error: results stand alone on standard output.
    let mut out: Box<dyn Write> = match leafwise::plugins::own_output() {
        Ok(file) => Box::new(LineWriter::new(file)),
        Err(_) => Box::new(io::stdout()),
    };
    let mut err = io::stderr();
    let mut console = Console::new(&mut out, &mut err, color, is_terminal);
    if let Err(error) = handler {
        console.prose(&format!(
            "warning: Ctrl-C will not write a checkpoint: {error}"
        ));
    }
    #[cfg(unix)]
    if let Err(error) = announced {
        console.prose(&format!(
            "warning: SIGUSR1 will not write a checkpoint: {error}"
        ));
    }
    ExitCode::from(leafwise_cli::run(
        std::env::args_os(),
        &mut console,
        &raised,
    ))
}
