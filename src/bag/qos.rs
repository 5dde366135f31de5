//! The quality of service that a topic was offered with, as bags write it down.
//!
//! It stands in a bag twice, in `metadata.yaml` and with the channel, and must be the same there:
//! readers match topics by it.

/// Longest duration that DDS knows, which means for ever.
const FOR_EVER: &str = "sec: 9223372036\n    nsec: 854775807";

/// What of it matters to whoever plays or hears it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Qos {
    /// Messages kept.
    pub depth: usize,
    /// Whether every message is to arrive.
    pub reliable: bool,
    /// Whether those who come late get what was sent before.
    pub transient_local: bool,
}

impl Default for Qos {
    fn default() -> Self {
        Self { depth: 10, reliable: true, transient_local: false }
    }
}

impl Qos {
    /// The list of this one profile, in YAML, as version 9 has it.
    pub fn to_yaml(self) -> String {
        let reliability = if self.reliable { "reliable" } else { "best_effort" };
        let durability = if self.transient_local { "transient_local" } else { "volatile" };
        format!(
            "- history: keep_last\n  depth: {}\n  reliability: {reliability}\n  \
             durability: {durability}\n  deadline:\n    {FOR_EVER}\n  lifespan:\n    {FOR_EVER}\n  \
             liveliness: automatic\n  liveliness_lease_duration:\n    {FOR_EVER}\n  \
             avoid_ros_namespace_conventions: false",
            self.depth
        )
    }

    /// The first of the profiles in a list, whichever version wrote it; what it does not say is as
    /// ROS has it by default.
    pub fn of_yaml(text: &str) -> Self {
        let value = |key: &str| {
            let line = |line: &str| {
                let line = line.trim_start_matches(['-', ' ']);
                let value = line.strip_prefix(key)?.strip_prefix(':')?;
                Some(value.trim().to_owned())
            };
            text.lines().find_map(line).unwrap_or_default()
        };
        Self {
            depth: value("depth").parse().ok().filter(|depth| *depth > 0).unwrap_or(10),
            reliable: !matches!(value("reliability").as_str(), "best_effort" | "2"),
            transient_local: matches!(value("durability").as_str(), "transient_local" | "1"),
        }
    }
}
