//! Version 1.0 of the interface.

#[rustfmt::skip]
mod convert;

#[allow(unreachable_pub, clippy::all)]
pub(super) mod bindings {
    //! The types generated from the interface's text.
    wasmtime::component::bindgen!({ world: "planner-plugin", path: "../../../sdk/wit/v1_0" });
}
