//! The tests of this crate, in one program.

mod canonical;
#[path = "../common/mod.rs"]
mod common;
mod linkages;
mod mutations;
mod robust;
mod rugged;
mod soil;
mod test_stand;
mod tracks;
mod tyres;
mod vehicles;
