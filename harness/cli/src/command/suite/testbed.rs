//! `vb-harness suite testbed`.

use std::path::PathBuf;

use clap::Args;
use vb_suite::testbed::{Testbed, TestbedParams};

use super::{DrawnArgs, must_be_free, name, rules, write};
use crate::error::CliError;
use crate::places;

#[derive(Debug, Args)]
pub(crate) struct TestbedArgs {
    #[command(flatten)]
    pub(crate) drawn: DrawnArgs,
    /// Rules of the beds; default: tasks/generator/testbed.yaml
    #[arg(long, value_name = "FILE")]
    pub(crate) params: Option<PathBuf>,
}

pub(crate) fn testbed(args: &TestbedArgs) -> Result<(), CliError> {
    must_be_free(&args.drawn.out)?;
    let params = rules::<TestbedParams>(args.params.as_deref())?;
    let model = places::catalog().model(&params.elevation.model, args.params.as_deref())?;
    let drawn = &args.drawn;
    let testbed = Testbed { rules: &params, model: &model, seed: drawn.seed };
    let worlds = testbed.worlds()?;
    let meta = testbed.meta(&name(drawn), &drawn.suite_version);
    write(&drawn.out, meta, worlds.into_iter().map(Ok))
}
