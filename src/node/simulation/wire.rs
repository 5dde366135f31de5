//! simulation_interfaces on the wire, as Kilted and Jazzy have it (1.5 and 1.6).
//!
//! Rolling (2.1) differs in one of these services: `SetEntityState` there ends with three flags.
//! Fields stand in the order of the definitions, in ros-simulation/simulation_interfaces; each has
//! its meaning there. A message without a field has one byte on the wire. Nothing here computes.
#![allow(missing_docs, reason = "each field is documented in its definition")]

use serde::{Deserialize, Serialize};

use crate::messages::{Header, Pose, Twist, Vector3};

macro_rules! wire {
    ($($(#[$meta:meta])* $name:ident { $($field:ident: $kind:ty),* $(,)? })*) => {$(
        $(#[$meta])*
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct $name { $(pub $field: $kind,)* }

        impl ros2_client::Message for $name {}
    )*};
}

wire! {
    /// What became of it.
    Result { result: u8, error_message: String }
    Resource { uri: String, resource_string: String }
    Bounds { kind: u8, points: Vec<Vector3> }
    EntityCategory { category: u8 }
    TagsFilter { tags: Vec<String>, filter_mode: u8 }
    EntityFilters {
        filter: String,
        categories: Vec<EntityCategory>,
        tags: TagsFilter,
        bounds: Bounds,
    }
    EntityInfo { category: EntityCategory, description: String, tags: Vec<String> }
    PoseStamped { header: Header, pose: Pose }
    EntityState { header: Header, pose: Pose, twist: Twist, acceleration: Twist }
    SimulationState { state: u8 }
    SimulatorFeatures { features: Vec<u16>, spawn_formats: Vec<String>, custom_info: String }
    SpawnResult { result: Result, entity_name: String }
    WorldResource {
        name: String,
        world_resource: Resource,
        description: String,
        tags: Vec<String>,
    }

    /// The request of services that ask for nothing more.
    Nothing { structure_needs_at_least_one_member: u8 }
    /// The response of services that tell nothing more.
    ResultResponse { result: Result }
    EntityRequest { entity: String }
    FiltersRequest { filters: EntityFilters }

    FeaturesResponse { features: SimulatorFeatures }
    StateResponse { state: SimulationState, result: Result }
    StateRequest { state: SimulationState }
    StepRequest { steps: u64 }
    ResetRequest { scope: u8 }
    EntitiesResponse { result: Result, entities: Vec<String> }
    EntityStateResponse { result: Result, state: EntityState }
    EntitiesStatesResponse { result: Result, entities: Vec<String>, states: Vec<EntityState> }
    SetEntityStateRequest { entity: String, state: EntityState }
    EntityInfoResponse { result: Result, info: EntityInfo }
    BoundsResponse { result: Result, bounds: Bounds }
    SpawnRequest {
        name: String,
        allow_renaming: bool,
        entity_resource: Resource,
        entity_namespace: String,
        initial_pose: PoseStamped,
    }
    SpawnResponse { result: Result, entity_name: String }
    SpawnManyRequest { spawn_requests: Vec<SpawnRequest> }
    SpawnManyResponse { result: Result, results: Vec<SpawnResult> }
    LoadRequest {
        world_resource: Resource,
        fail_on_unsupported_element: bool,
        ignore_missing_or_unsupported_assets: bool,
    }
    WorldResponse { result: Result, world: WorldResource }
    WorldsRequest {
        additional_sources: Vec<String>,
        filter: TagsFilter,
        offline_only: bool,
        continue_on_error: bool,
    }
    WorldsResponse { result: Result, worlds: Vec<WorldResource> }

    /// The goal of the action.
    StepsGoal { steps: u64 }
    /// Its result.
    StepsResult { result: Result }
    /// Its feedback.
    StepsFeedback { completed_steps: u64, remaining_steps: u64 }
}

/// Handles of a goal are as copyable as the goal.
impl Copy for StepsGoal {}

/// Codes of [`Result`]; those above 100 are a service's own.
pub mod code {
    pub const OK: u8 = 1;
    pub const NOT_FOUND: u8 = 2;
    pub const INCORRECT_STATE: u8 = 3;
    pub const OPERATION_FAILED: u8 = 4;

    /// set_simulation_state
    pub const ALREADY_IN_TARGET_STATE: u8 = 101;
    pub const STATE_TRANSITION_ERROR: u8 = 102;
    pub const INCORRECT_TRANSITION: u8 = 103;

    /// spawn_entity
    pub const NAME_NOT_UNIQUE: u8 = 101;
    pub const NAME_INVALID: u8 = 102;
    pub const UNSUPPORTED_FORMAT: u8 = 103;
    pub const NO_RESOURCE: u8 = 104;
    pub const NAMESPACE_INVALID: u8 = 105;
    pub const RESOURCE_PARSE_ERROR: u8 = 106;
    pub const INVALID_POSE: u8 = 109;
    /// spawn_entities
    pub const ENTITIES_SPAWN_FAILED: u8 = 150;

    /// set_entity_state
    pub const STATE_INVALID_POSE: u8 = 101;

    /// load_world
    pub const WORLD_UNSUPPORTED_FORMAT: u8 = 101;
    pub const WORLD_NO_RESOURCE: u8 = 102;
    pub const WORLD_PARSE_ERROR: u8 = 103;
    /// unload_world, get_current_world
    pub const NO_WORLD_LOADED: u8 = 101;
}

/// [`SimulationState`]
pub mod state {
    pub const STOPPED: u8 = 0;
    pub const PLAYING: u8 = 1;
    pub const PAUSED: u8 = 2;
    pub const QUITTING: u8 = 3;
    pub const NO_WORLD: u8 = 4;
}

/// [`Bounds`]
pub mod bounds {
    pub const EMPTY: u8 = 0;
    pub const BOX: u8 = 1;
    pub const CONVEX_HULL: u8 = 2;
    pub const SPHERE: u8 = 3;
}

/// [`EntityCategory`]
pub mod category {
    pub const ROBOT: u8 = 1;
    pub const DYNAMIC_OBJECT: u8 = 4;
    pub const STATIC_OBJECT: u8 = 5;
}

/// Bits of the scope of a reset.
pub mod scope {
    pub const TIME: u8 = 1;
    pub const STATE: u8 = 2;
    pub const SPAWNED: u8 = 4;
    pub const ALL: u8 = 255;
}

/// What this simulator can do: spawning, deleting; tags, bounds (spheres, boxes, hulls) and
/// categories of entities; spawning from a string; getting and setting their state, getting their
/// info; resets of time, state and what was spawned; getting, setting and pausing the simulation;
/// one step, many, and by the action; loading worlds, from a string too, unloading them, telling of
/// the current and of those there are; spawning many.
pub const FEATURES: [u16; 27] = [
    0, 1, 4, 5, 6, 7, 8, 9, 10, 11, 12, 20, 21, 22, 23, 24, 25, 26, 31, 32, 33, 40, 41, 43, 44, 45,
    50,
];
