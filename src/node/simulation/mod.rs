//! simulation_interfaces: the standard services by which tools start, stop, step, reset, fill and
//! look into a simulation. Names are relative: `get_entities`, under a namespace `/a/get_entities`.
//!
//! | file | holds |
//! |---|---|
//! | `services` | a call on the [`Stage`](super::stage::Stage) for each service, and its answer |
//! | `entities` | pucks as entities, and the filters over them |
//! | `steps` | steps of a paused simulation, for the service and the action that count them |
//! | `wire` | the messages |

pub mod entities;
pub mod services;
pub mod steps;
pub mod wire;
