//! The macro that exports a planner as a plugin.

/// Exports a [`Planner`](crate::Planner) as a plugin, WASM or native.
///
/// ```
/// # use vb_sdk::{Command, Observation, Planner, PlannerError, Task};
/// # struct Stand;
/// # impl Planner for Stand {
/// #     fn init(_: &Task) -> Result<Self, PlannerError> { Ok(Self) }
/// #     fn step(&mut self, _: &Observation) -> Result<Command, PlannerError> { Ok(Command::default()) }
/// # }
/// vb_sdk::export_planner! {
///     planner: Stand,
///     name: "stand",
///     about: "Doesn't move",
///     control_period: 0.1,
///     params: { speed: 3.0 => "target speed, m/s" }
/// }
/// ```
/// `name` may contain `a-z`, `0-9`, `-` and `_`. `control_period` is in seconds, a multiple of 0.001. `params` is
/// optional. `needs: { pose, lidar: 10, local_map: 5 }` after it requests sensors with their rates, Hz (divisors of
/// 100); by default a planner receives pose and wheel odometry in every step. `without_maps: { local_map: 10 }`
/// requests additional sensors for tasks in which the perception profile omits a map. `models: [..]` names learned
/// weights and their hashes, as constant texts. Version and authors are those of the crate. Invoke the macro once per
/// crate.
#[macro_export]
macro_rules! export_planner {
    (
        planner: $planner:ty,
        name: $name:literal,
        about: $about:literal,
        control_period: $period:literal
        $(, params: { $($key:ident : $default:literal => $help:literal),* $(,)? })?
        $(, needs: { $($need:ident $(: $rate:literal)?),* $(,)? })?
        $(, without_maps: { $($more:ident $(: $often:literal)?),* $(,)? })?
        $(, models: [ $($model:expr),* $(,)? ])? $(,)?
    ) => {
        const _: () = {
            const FIELDS: &[(&str, &str)] = &[
                ("abi", $crate::ABI_VERSION),
                ("name", $name),
                ("version", env!("CARGO_PKG_VERSION")),
                ("authors", env!("CARGO_PKG_AUTHORS")),
                ("about", $about),
                ("control-period", concat!($period)),
                $($(
                    ("param", stringify!($key)),
                    ("default", concat!($default)),
                    ("help", $help),
                )*)?
                $($(("need", concat!(stringify!($need) $(, " ", $rate)?)),)*)?
                $($(("need-without-maps", concat!(stringify!($more) $(, " ", $often)?)),)*)?
                $($(("model", $model),)*)?
            ];
            const _: () = {
                assert!($crate::metadata::is_name($name), "name: only a-z, 0-9, - and _");
                assert!(
                    $crate::metadata::is_control_period($period),
                    "control_period: a positive multiple of 0.001 s, with a decimal point"
                );
            };
            const LENGTH: usize = $crate::metadata::encoded_len(FIELDS);

            #[used]
            #[cfg_attr(target_family = "wasm", unsafe(link_section = "vb:planner"))]
            #[cfg_attr(
                all(not(target_family = "wasm"), not(target_vendor = "apple")),
                unsafe(link_section = ".vb.planner")
            )]
            #[cfg_attr(target_vendor = "apple", unsafe(link_section = "__DATA,__vb_planner"))]
            static METADATA: [u8; LENGTH] = $crate::metadata::encode(FIELDS);

            $crate::__export_carrier!($planner, METADATA);
        };
    };
}

#[cfg(target_family = "wasm")]
#[doc(hidden)]
#[macro_export]
macro_rules! __export_carrier {
    ($planner:ty, $metadata:ident) => {
        type VbGuest = $crate::wasm::Guest<$planner>;
        $crate::wasm::export!(VbGuest with_types_in $crate::wasm::bindings);
    };
}

#[cfg(not(target_family = "wasm"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __export_carrier {
    ($planner:ty, $metadata:ident) => {
        extern "C" fn vb_root_module() -> $crate::__abi_stable::library::RootModuleResult {
            $crate::native::erased_module::<$planner>(&$metadata)
        }

        // Under the name that abi_stable looks for; its own attribute predates `unsafe(no_mangle)`.
        #[unsafe(export_name = "_1as_0lib_1header_0root_bmodule_bloader")]
        #[allow(missing_docs)]
        pub static VB_ROOT_MODULE: $crate::__abi_stable::library::LibHeader =
            // SAFETY: the constructor returns an erased `PlannerModuleRef`.
            unsafe {
                $crate::__abi_stable::library::LibHeader::from_constructor::<$crate::native::PlannerModuleRef>(
                    vb_root_module,
                    $crate::__abi_stable::library::CheckTypeLayout::Yes,
                )
            };
    };
}
