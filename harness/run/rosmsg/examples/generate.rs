//! Writes `src/messages.rs` from the folder `msg`.

use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let source = vb_rosmsg::idl::Definitions::load(&root.join("msg"))?.rust()?;
    std::fs::write(root.join("src/messages.rs"), source)?;
    Ok(())
}
