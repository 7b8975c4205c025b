//! From a command to what carries it out. Groups of commands dispatch where their work is done.

use crate::args::{Cli, Command};
use crate::error::CliError;
use crate::output;

impl Cli {
    /// Does what the program was called for.
    ///
    /// # Errors
    /// What went wrong with the work itself.
    pub(crate) fn run(&self) -> Result<(), CliError> {
        output::set_up(self.global);
        self.command.run()
    }
}

impl Command {
    fn run(&self) -> Result<(), CliError> {
        match self {
            Self::Run(args) => crate::run::run(args),
            #[cfg(feature = "ros")]
            Self::Ros(args) => crate::ros::ros(args),
            Self::List(args) => crate::list::list(args),
            Self::Merge(args) => crate::merge::merge(args),
            Self::Sweep(command) => command.run(),
            Self::Score(args) => crate::score::score(args),
            Self::Report(args) => crate::report::report(args),
            #[cfg(feature = "replay")]
            Self::Replay(args) => crate::replay::replay(args),
            #[cfg(feature = "dataset")]
            Self::Dataset(command) => command.run(),
            Self::Commands(args) => crate::commands::commands(args),
            Self::Submit(args) => crate::submission::submit(args),
            Self::Verify(args) => crate::submission::verify(args),
            Self::Evaluate(args) => crate::submission::evaluate(args),
            Self::Leaderboard(command) => command.run(),
            Self::Inspect(args) => crate::inspect::inspect(args),
            Self::Check(args) => crate::check::check(args),
            Self::Plugin(command) => command.run(),
            Self::Suite(command) => command.run(),
            Self::Tasks(command) => command.run(),
            #[cfg(feature = "vehicle")]
            Self::Vehicle(command) => command.run(),
            #[cfg(feature = "terrain")]
            Self::Terrain(command) => command.run(),
            Self::Completions(args) => {
                crate::shell::completions(args);
                Ok(())
            }
            Self::Man(args) => crate::shell::man(args),
        }
    }
}
