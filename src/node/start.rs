//! What a node is before it runs: its name, and what command line and environment say about it.

use ros2_client::ParameterValue;

use super::NodeError;
use super::arguments::{Override, RosArguments};
use super::dds::DOMAIN_ID_MAX;
use super::names::Names;
use super::parameters::Parameter;

/// Parameters that decide which scene runs and how: asked for here, before there is a node.
const OF_THE_RUN: [&str; 9] =
    ["scene", "method", "step_s", "keep_all", "rate", "for_s", "error", "budget", "record"];

/// Name, parameters and log of the node that is about to start.
#[derive(Clone, Debug)]
pub struct Start {
    pub(super) names: Names,
    /// Those for this node, in their order.
    values: Vec<Override>,
    pub(super) log_level: Option<&'static str>,
}

impl Start {
    /// Of what came after `--ros-args`, if anything, and of ROS_NAMESPACE.
    ///
    /// # Errors
    /// [`NodeError::BadUse`] of a name that ROS does not allow.
    pub fn new(ros: RosArguments) -> Result<Self, NodeError> {
        let RosArguments { rules, mut values, log_level } = ros;
        let namespace = environment("ROS_NAMESPACE").unwrap_or_default();
        let bad_use = |error: &dyn std::fmt::Display| NodeError::BadUse(error.to_string());
        let names = Names::new("carom", &namespace, rules).map_err(|error| bad_use(&error))?;
        let node = names.to_string();
        values.retain(|value| value.is_for(&node));
        Ok(Self { names, values, log_level })
    }

    /// A parameter of the run that is text.
    ///
    /// # Errors
    /// [`NodeError::BadUse`] if it is something else.
    pub fn text(&self, name: &'static str) -> Result<Option<String>, NodeError> {
        match self.value(name, ParameterValue::String(String::new()))? {
            Some(ParameterValue::String(text)) => Ok(Some(text)),
            _ => Ok(None),
        }
    }

    /// A parameter of the run that is a number.
    ///
    /// # Errors
    /// As of [`Start::text`].
    pub fn number(&self, name: &'static str) -> Result<Option<f64>, NodeError> {
        match self.value(name, ParameterValue::Double(0.0))? {
            Some(ParameterValue::Double(number)) => Ok(Some(number)),
            _ => Ok(None),
        }
    }

    /// A parameter of the run that is true or false.
    ///
    /// # Errors
    /// As of [`Start::text`].
    pub fn flag(&self, name: &'static str) -> Result<Option<bool>, NodeError> {
        match self.value(name, ParameterValue::Boolean(false))? {
            Some(ParameterValue::Boolean(flag)) => Ok(Some(flag)),
            _ => Ok(None),
        }
    }

    /// The last value for it, of the type of the other.
    fn value(
        &self,
        name: &'static str,
        like: ParameterValue,
    ) -> Result<Option<ParameterValue>, NodeError> {
        debug_assert!(OF_THE_RUN.contains(&name), "{name} is no parameter of the run");
        let Some(last) = self.values.iter().rfind(|value| value.name == name) else {
            return Ok(None);
        };
        let taken = Parameter::new(name, like, "").take(last.value.clone());
        taken.map(Some).map_err(NodeError::BadUse)
    }

    /// What is left for the node's own parameters: those of the run are decided.
    pub(super) fn values(&self) -> Vec<Override> {
        let left = |value: &&Override| !OF_THE_RUN.contains(&value.name.as_str());
        self.values.iter().filter(left).cloned().collect()
    }
}

/// A variable of the environment.
pub(super) fn environment(name: &str) -> Option<String> {
    std::env::var(name).ok()
}

/// ROS_DOMAIN_ID, 0 where there is none.
///
/// # Errors
/// [`NodeError::BadUse`] if it is no domain.
pub(super) fn domain_id() -> Result<u16, NodeError> {
    let Some(text) = environment("ROS_DOMAIN_ID").filter(|text| !text.is_empty()) else {
        return Ok(0);
    };
    let id = text.parse().ok().filter(|id| *id <= DOMAIN_ID_MAX);
    id.ok_or_else(|| {
        NodeError::BadUse(format!("ROS_DOMAIN_ID={text}: must be 0 to {DOMAIN_ID_MAX}"))
    })
}
