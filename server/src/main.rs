//! The command `fogbank`: a fog preview server, and the same on the command line.

mod accept;
mod answer;
mod app;
mod cli;
mod commands;
mod extract;
mod layers;
mod openapi;
mod picture;
mod problem;
mod queue;
mod routes;
mod serve;
mod socket;
mod watch;

use clap::Parser;
use cli::{Cli, Command};
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse();
    // Without a command it serves; parsed again, so that the environment counts as well.
    let command = cli.command.or_else(|| Cli::parse_from(["fogbank", "serve"]).command);
    let result = match command {
        Some(Command::Render(args)) => commands::render(args),
        Some(Command::Probe(args)) => commands::probe(args),
        Some(Command::Compare(args)) => commands::compare(args),
        Some(Command::Backends) => commands::backends(),
        Some(Command::Schema) => commands::schema(),
        Some(Command::Serve(args)) => serve::serve(args),
        None => Ok(()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            for line in failure.0 {
                let _ = writeln!(std::io::stderr(), "fogbank: {line}");
            }
            ExitCode::FAILURE
        }
    }
}
