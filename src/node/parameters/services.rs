//! The six parameter services and `/parameter_events`, with the semantics of rclcpp.
//!
//! Requests go to the loop like messages, so that a change falls between two steps.

use ros2_client::ParameterValue;
use ros2_client::parameters::raw;
use ros2_client::rcl_interfaces::{
    DescribeParametersRequest, DescribeParametersResponse, GetParameterTypesRequest,
    GetParameterTypesResponse, GetParametersRequest, GetParametersResponse, ListParametersRequest,
    ListParametersResponse, ListParametersResult, SetParametersAtomicallyResponse,
    SetParametersRequest, SetParametersResponse,
};

use serde::{Deserialize, Serialize};

use super::{Parameters, Veto};
use crate::messages::Time;
use crate::node::dds::DdsError;
use crate::node::service::services;

services! { "rcl_interfaces":
    GetParameters GetParametersRequest => GetParametersResponse, "~/get_parameters";
    GetParameterTypes GetParameterTypesRequest => GetParameterTypesResponse,
        "~/get_parameter_types";
    SetParameters SetParametersRequest => SetParametersResponse, "~/set_parameters";
    SetParametersAtomically SetParametersRequest => SetParametersAtomicallyResponse,
        "~/set_parameters_atomically";
    DescribeParameters DescribeParametersRequest => DescribeParametersResponse,
        "~/describe_parameters";
    ListParameters ListParametersRequest => ListParametersResponse, "~/list_parameters";
}

/// What was set, by name.
pub type Changed = Vec<(String, ParameterValue)>;

/// Answers a request; what it changed, for the loop to act on and for `/parameter_events`.
pub fn answer(
    request: &Request,
    parameters: &mut Parameters,
    veto: Veto,
) -> (Changed, Result<(), DdsError>) {
    let names = |names: &[String]| names.iter().map(|name| parameters.value(name)).collect();
    let nothing = |answered| (Vec::new(), answered);
    match request {
        Request::GetParameters(asked) => {
            let values: Vec<ParameterValue> = names(&asked.request.names);
            let values = values.into_iter().map(Into::into).collect();
            nothing(asked.answer(GetParametersResponse { values }))
        }
        Request::GetParameterTypes(asked) => {
            let values: Vec<ParameterValue> = names(&asked.request.names);
            let values = values.iter().map(ParameterValue::to_parameter_type_raw).collect();
            nothing(asked.answer(GetParameterTypesResponse { values }))
        }
        Request::DescribeParameters(asked) => {
            let names = asked.request.names.iter();
            let values = names.map(|name| parameters.describe(name)).collect();
            let answered = match asked.answer(DescribeParametersResponse { values }) {
                // What rclcpp answers where it cannot describe: nothing; the log has why.
                Err(error @ DdsError::TooLarge(_)) => {
                    let nothing = DescribeParametersResponse { values: Vec::new() };
                    asked.answer(nothing).and(Err(error))
                }
                answered => answered,
            };
            nothing(answered)
        }
        Request::ListParameters(asked) => {
            let (names, prefixes) = parameters.list(&asked.request.prefixes, asked.request.depth);
            let result = ListParametersResult { names, prefixes };
            nothing(asked.answer(ListParametersResponse { result }))
        }
        Request::SetParameters(asked) => {
            let mut changed = Vec::new();
            let one_by_one = asked.request.parameter.iter().map(|each| {
                parameters.set(vec![named(each)], veto).map(|set| changed.extend(set)).into()
            });
            let results = one_by_one.collect();
            (changed, asked.answer(SetParametersResponse { results }))
        }
        Request::SetParametersAtomically(asked) => {
            let values = asked.request.parameter.iter().map(named).collect();
            let (changed, result) = match parameters.set(values, veto) {
                Ok(changed) => (changed, Ok(())),
                Err(reason) => (Vec::new(), Err(reason)),
            };
            (changed, asked.answer(SetParametersAtomicallyResponse { result: result.into() }))
        }
    }
}

fn named(parameter: &raw::Parameter) -> (String, ParameterValue) {
    (parameter.name.clone(), parameter.value.clone().into())
}

/// rcl_interfaces/msg/ParameterEvent
#[derive(Clone, Debug, Serialize, Deserialize)]
#[allow(missing_docs, reason = "as in its .msg file")]
pub struct ParameterEvent {
    pub stamp: Time,
    pub node: String,
    pub new_parameters: Vec<raw::Parameter>,
    pub changed_parameters: Vec<raw::Parameter>,
    pub deleted_parameters: Vec<raw::Parameter>,
}

impl ParameterEvent {
    /// What was declared, or what was changed.
    pub fn new(stamp: Time, node: &str, new: Changed, changed: Changed) -> Self {
        let one =
            |(name, value): (String, ParameterValue)| raw::Parameter { name, value: value.into() };
        Self {
            stamp,
            node: node.to_owned(),
            new_parameters: new.into_iter().map(one).collect(),
            changed_parameters: changed.into_iter().map(one).collect(),
            deleted_parameters: Vec::new(),
        }
    }
}
