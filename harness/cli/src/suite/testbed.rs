//! `vb-harness suite testbed`.

use vb_suite::testbed::{Testbed, TestbedParams};
use vb_world::SuiteWriter;

use super::{done, folder_name, rules, terrain_model, write_error};
use crate::args::TestbedArgs;
use crate::error::CliError;

pub(crate) fn testbed(args: &TestbedArgs) -> Result<(), CliError> {
    let params = rules(args.params.as_deref(), TestbedParams::parse)?;
    let model = terrain_model(&params.elevation.model, args.params.as_deref())?;
    let testbed = Testbed { rules: &params, model: &model, seed: args.seed };
    let worlds = testbed.worlds().map_err(CliError::input)?;
    let name = args.name.clone().unwrap_or_else(|| folder_name(&args.out));
    let meta = testbed.meta(&name, &args.suite_version);
    let mut writer = SuiteWriter::create(&args.out, meta).map_err(write_error)?;
    for world in &worlds {
        writer.add(world).map_err(write_error)?;
    }
    done(&writer.finish().map_err(write_error)?);
    Ok(())
}
