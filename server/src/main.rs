//! The command `fogbank`: a fog preview server, and the same on the command line.

mod accept;
mod answer;
mod app;
mod budget;
mod cli;
mod commands;
mod conditional;
mod connections;
mod edits;
mod estimate;
mod extract;
mod import;
mod layers;
mod live;
mod log;
mod openapi;
mod origin;
mod pace;
mod picture;
mod problem;
mod query;
mod queue;
mod routes;
mod scene_id;
mod seat;
mod serve;
mod session;
mod socket;
mod store;
mod watch;

use clap::Parser;
use cli::{Cli, Command};
use std::io::Write;
use std::process::ExitCode;

/// Keeps for a second what a frame gives back, because the next frame asks for as much again: from
/// the C library every frame got all its pages anew, at 3 to 10 % of a draft's time.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let command = cli.command.unwrap_or(Command::Serve(cli.serve));
    let draws = matches!(
        command,
        Command::Serve(_) | Command::Render(_) | Command::Compare(_) | Command::Backends
    );
    if draws {
        session::leave_wayland_alone();
    }
    let result = match command {
        Command::Render(args) => commands::render(args),
        Command::Probe(args) => commands::probe(args),
        Command::Compare(args) => commands::compare(args),
        Command::Backends => commands::backends(),
        Command::Schema => commands::schema(),
        Command::Import(args) => import::import(args),
        Command::Fogmap(args) => import::fogmap(args),
        Command::Serve(args) => serve::serve(args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            for line in failure.lines {
                let _ = writeln!(std::io::stderr(), "fogbank: {line}");
            }
            ExitCode::from(failure.cause as u8)
        }
    }
}
