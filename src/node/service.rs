//! Services over DDS: requests as a stream, answers through the same handle.
//!
//! An answer must fit into one datagram: RustDDS 0.15.1 writes a stray byte into each fragment that
//! carries inline QoS, as every fragment of a service's answer does, so that no client can read it
//! (`DataFrag::write_to` writes the `Option`, not what is in it). What is larger is refused here,
//! and the caller says so instead.
//! As in `dds`, nothing here blocks: an answer that DDS cannot take at once is lost, and the client
//! asks again. A request that is not of its type is an error, and reading goes on.

use std::rc::Rc;

use futures::Stream;
use ros2_client::service::Server;
use ros2_client::{Message, RmwRequestId, WriteError};

use super::dds::DdsError;

/// Largest answer, bytes: a datagram of 1452, less its headers.
const ANSWER_BYTES: usize = 1_280;

/// A service and the two messages of it.
pub trait RosService: 'static {
    /// The interface package.
    const PACKAGE: &'static str;
    /// The name in `srv/`.
    const TYPE: &'static str;
    /// What a client asks.
    type Request: Message + Clone + 'static;
    /// What it is told.
    type Response: Message + 'static;
}

/// One that is open. Clones are the same service.
pub struct Service<S: RosService> {
    inner: Rc<Server<S::Request, S::Response>>,
}

impl<S: RosService> Service<S> {
    /// Of a server that `dds` made.
    pub fn new(server: Server<S::Request, S::Response>) -> Self {
        Self { inner: Rc::new(server) }
    }

    /// All requests from now on; it never ends.
    pub fn requests(&self) -> impl Stream<Item = Result<Asked<S>, DdsError>> + use<S> {
        futures::stream::unfold(self.inner.clone(), async |server| {
            let asked = server.async_receive_request().await;
            let asked = asked.map_err(|error| DdsError::Undecodable(error.to_string()));
            let with = |(id, request)| Asked { server: server.clone(), id, request };
            let asked = asked.map(with);
            Some((asked, server))
        })
    }
}

/// A request that waits for its answer.
pub struct Asked<S: RosService> {
    server: Rc<Server<S::Request, S::Response>>,
    id: RmwRequestId,
    /// What is asked.
    pub request: S::Request,
}

impl<S: RosService> Asked<S> {
    /// Answers it.
    ///
    /// # Errors
    /// [`DdsError::TooLarge`] if the answer would not arrive: then another may be given.
    pub fn answer(&self, response: S::Response) -> Result<(), DdsError> {
        let unsent = |error: &dyn std::fmt::Display| DdsError::Send(error.to_string());
        let bytes = cdr_encoding::to_vec::<S::Response, byteorder::LittleEndian>(&response);
        let bytes = bytes.map_err(|error| unsent(&error))?.len();
        if bytes > ANSWER_BYTES {
            return Err(DdsError::TooLarge(bytes));
        }
        self.server.send_response(self.id, response).map_err(|error| match error {
            WriteError::WouldBlock { .. } => DdsError::WindowFull,
            other => DdsError::Send(other.to_string()),
        })
    }
}

/// Services of one package: a type each, `Request` over all of them, and `open`, which makes one
/// stream of what they are asked.
macro_rules! services {
    ($package:literal: $($service:ident $request:ty => $response:ty, $name:literal;)*) => {
        $(
            #[doc = concat!($package, "/srv/", stringify!($service))]
            pub struct $service;

            impl $crate::node::service::RosService for $service {
                const PACKAGE: &'static str = $package;
                const TYPE: &'static str = stringify!($service);
                type Request = $request;
                type Response = $response;
            }
        )*

        /// A request to one of them.
        pub enum Request {
            $(#[doc = concat!($package, "/srv/", stringify!($service))]
            $service($crate::node::service::Asked<$service>),)*
        }

        /// Opens all of them.
        pub fn open(
            ros: &mut $crate::node::dds::Ros,
        ) -> Result<
            futures::stream::LocalBoxStream<'static, Result<Request, $crate::node::dds::DdsError>>,
            $crate::node::dds::DdsError,
        > {
            use futures::StreamExt;
            let mut streams = Vec::new();
            $({
                let requests = ros.service::<$service>($name)?.requests();
                streams.push(requests.map(|asked| asked.map(Request::$service)).boxed_local());
            })*
            Ok(futures::stream::select_all(streams).boxed_local())
        }
    };
}
pub(crate) use services;
