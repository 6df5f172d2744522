//! The six services through which tools read and set a node's parameters.
//!
//! ros2-client has its own; these say what each parameter is for and where it must lie, and refuse with a reason.

use super::newcomer::Newcomer;
use super::parameter_store::ParameterStore;
use super::publishers::{EntityError, dds_name};
use super::qos;
use super::remap::Names;
use futures::stream::{self, LocalBoxStream, StreamExt};
use ros2_client::parameters::{Parameter, ParameterValue, raw};
use ros2_client::rcl_interfaces::{
    DescribeParametersRequest, DescribeParametersResponse, GetParameterTypesRequest,
    GetParameterTypesResponse, GetParametersRequest, GetParametersResponse, ListParametersRequest,
    ListParametersResponse, SetParametersAtomicallyResponse, SetParametersRequest,
    SetParametersResponse,
};
use ros2_client::{Message, RmwRequestId, Server, ServiceMapping, ServiceTypeName};

/// The servers.
pub struct ParameterServices {
    get: Server<GetParametersRequest, GetParametersResponse>,
    get_types: Server<GetParameterTypesRequest, GetParameterTypesResponse>,
    list: Server<ListParametersRequest, ListParametersResponse>,
    describe: Server<DescribeParametersRequest, DescribeParametersResponse>,
    set: Server<SetParametersRequest, SetParametersResponse>,
    set_atomically: Server<SetParametersRequest, SetParametersAtomicallyResponse>,
}

/// A request to one of them.
pub enum ParameterRequest {
    /// get_parameters.
    Get(RmwRequestId, GetParametersRequest),
    /// get_parameter_types.
    GetTypes(RmwRequestId, GetParameterTypesRequest),
    /// list_parameters.
    List(RmwRequestId, ListParametersRequest),
    /// describe_parameters.
    Describe(RmwRequestId, DescribeParametersRequest),
    /// set_parameters.
    Set(RmwRequestId, SetParametersRequest),
    /// set_parameters_atomically.
    SetAtomically(RmwRequestId, SetParametersRequest),
}

/// A server of a standard service.
pub fn server<Req, Resp>(
    newcomer: &mut Newcomer,
    names: &Names,
    name: &str,
    (package, kind): (&str, &str),
) -> Result<Server<Req, Resp>, EntityError>
where
    Req: Message + Clone + 'static,
    Resp: Message + 'static,
{
    Ok(newcomer.node().create_server(
        ServiceMapping::Enhanced,
        &dds_name(&names.service(name)?)?,
        &ServiceTypeName::new(package, kind),
        qos::services(),
        qos::services(),
    )?)
}

impl ParameterServices {
    /// Makes them all.
    ///
    /// # Errors
    /// [`EntityError`] for the first that cannot be made.
    pub fn open(node: &mut Newcomer, names: &Names) -> Result<Self, EntityError> {
        const PACKAGE: &str = "rcl_interfaces";
        Ok(Self {
            get: server(node, names, "~/get_parameters", (PACKAGE, "GetParameters"))?,
            get_types: server(
                node,
                names,
                "~/get_parameter_types",
                (PACKAGE, "GetParameterTypes"),
            )?,
            list: server(
                node,
                names,
                "~/list_parameters",
                (PACKAGE, "ListParameters"),
            )?,
            describe: server(
                node,
                names,
                "~/describe_parameters",
                (PACKAGE, "DescribeParameters"),
            )?,
            set: server(node, names, "~/set_parameters", (PACKAGE, "SetParameters"))?,
            set_atomically: server(
                node,
                names,
                "~/set_parameters_atomically",
                (PACKAGE, "SetParametersAtomically"),
            )?,
        })
    }

    /// The requests as they come.
    pub fn requests(&self) -> LocalBoxStream<'_, ParameterRequest> {
        fn of<'a, Req, Resp>(
            server: &'a Server<Req, Resp>,
            wrap: impl Fn(RmwRequestId, Req) -> ParameterRequest + 'a,
        ) -> LocalBoxStream<'a, ParameterRequest>
        where
            Req: Message + 'static,
            Resp: Message + 'static,
        {
            requests(server)
                .map(move |(id, request)| wrap(id, request))
                .boxed_local()
        }
        stream::select_all([
            of(&self.get, ParameterRequest::Get),
            of(&self.get_types, ParameterRequest::GetTypes),
            of(&self.list, ParameterRequest::List),
            of(&self.describe, ParameterRequest::Describe),
            of(&self.set, ParameterRequest::Set),
            of(&self.set_atomically, ParameterRequest::SetAtomically),
        ])
        .boxed_local()
    }

    /// Answers a request, and says which parameters were set.
    pub fn answer(&self, request: ParameterRequest, store: &mut ParameterStore) -> Vec<Parameter> {
        let mut taken = Vec::new();
        match request {
            ParameterRequest::Get(id, request) => {
                let values = request.names.iter().map(|name| store.get(name).into());
                let values = values.collect();
                send(&self.get, id, GetParametersResponse { values });
            }
            ParameterRequest::GetTypes(id, request) => {
                let value = |name: &String| ParameterValue::to_parameter_type_raw(&store.get(name));
                let values = request.names.iter().map(value).collect();
                send(&self.get_types, id, GetParameterTypesResponse { values });
            }
            ParameterRequest::List(id, request) => {
                let result = store.list(&request.prefixes);
                send(&self.list, id, ListParametersResponse { result });
            }
            ParameterRequest::Describe(id, request) => {
                let values = request.names.iter().map(|name| store.describe(name).into());
                let values = values.collect();
                send(&self.describe, id, DescribeParametersResponse { values });
            }
            ParameterRequest::Set(id, request) => {
                let results;
                (results, taken) = store.set_each(parameters(request));
                let results = results.into_iter().map(raw::SetParametersResult::from);
                let results = results.collect();
                send(&self.set, id, SetParametersResponse { results });
            }
            ParameterRequest::SetAtomically(id, request) => {
                let result = store.set(parameters(request)).map(|set| taken = set).into();
                let response = SetParametersAtomicallyResponse { result };
                send(&self.set_atomically, id, response);
            }
        }
        taken
    }
}

fn parameters(request: SetParametersRequest) -> Vec<Parameter> {
    request.parameter.into_iter().map(Parameter::from).collect()
}

/// Requests to a server; what cannot be read is passed over.
pub fn requests<Req, Resp>(
    server: &Server<Req, Resp>,
) -> impl futures::Stream<Item = (RmwRequestId, Req)> + '_
where
    Req: Message + 'static,
    Resp: Message + 'static,
{
    server.receive_request_stream().filter_map(|request| {
        let request = request
            .inspect_err(|error| tracing::warn!("a request that cannot be read: {error}"))
            .ok();
        std::future::ready(request)
    })
}

/// Sends a response; the caller may be gone already.
pub fn send<Req, Resp>(server: &Server<Req, Resp>, id: RmwRequestId, response: Resp)
where
    Req: Message + 'static,
    Resp: Message + 'static,
{
    if let Err(error) = server.send_response(id, response) {
        tracing::warn!("a response was not sent: {error}");
    }
}
