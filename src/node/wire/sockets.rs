//! Sockets: datagrams in and out. They never wait for anybody, and keep no more than the system
//! does.
//!
//! What arrives is handed over in batches, so that a flood costs the loop a bounded time at a turn;
//! what the system has no room for is lost, as UDP has it.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4};
use std::rc::Rc;

use futures::stream::{self, LocalBoxStream, StreamExt};
use socket2::{Domain, Protocol, Socket, Type};
use tokio::net::UdpSocket;

use crate::wire::{Team, limits};

/// Most datagrams handed over at a turn.
const BATCH: usize = 64;
/// Room that is asked for datagrams that nobody has read yet, bytes; the system may give less.
const RECEIVE_BYTES: usize = 1 << 20;

/// What a port is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// SSL: control of the simulation.
    Control,
    /// SSL: commands to the robots of a team.
    Robots(Team),
    /// SSL: the older packets of grSim.
    GrSim,
    /// VSSS: commands to all robots, and replacements.
    Vsss,
}

impl Purpose {
    /// For the log.
    pub fn name(self) -> &'static str {
        match self {
            Self::Control => "simulation control",
            Self::Robots(Team::Blue) => "blue robots",
            Self::Robots(Team::Yellow) => "yellow robots",
            Self::GrSim => "grsim packets",
            Self::Vsss => "vsss packets",
        }
    }
}

/// Datagrams that arrived at a port, oldest first; those that are too long are only so long.
pub struct Batch {
    /// Where.
    pub purpose: Purpose,
    /// From whom, and what.
    pub datagrams: Vec<(SocketAddr, Vec<u8>)>,
    /// To answer through.
    pub socket: Rc<UdpSocket>,
}

/// Opens a port to listen on.
///
/// # Errors
/// What the system says, with the address.
pub fn listen(address: SocketAddrV4, purpose: Purpose) -> Result<std::net::UdpSocket, String> {
    let open = || -> io::Result<std::net::UdpSocket> {
        let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
        // Less room than this is no reason not to run.
        let _ = socket.set_recv_buffer_size(RECEIVE_BYTES);
        socket.set_nonblocking(true)?;
        socket.bind(&SocketAddr::from(address).into())?;
        Ok(socket.into())
    };
    open().map_err(|error| {
        let what = purpose.name();
        format!("cannot listen on {address} for {what}: {error}; --wire-ports chooses others")
    })
}

/// How datagrams leave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Way {
    /// The interface for groups, by name or address; nothing = the system's choice.
    pub interface: Option<String>,
    /// How many networks groups reach: 0 = this machine, 1 = its own network.
    pub reach: u32,
}

/// Opens a socket to send from.
///
/// # Errors
/// What the system says.
pub fn sender(way: &Way) -> Result<std::net::UdpSocket, String> {
    let open = || -> io::Result<std::net::UdpSocket> {
        let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
        socket.set_nonblocking(true)?;
        socket.set_multicast_ttl_v4(way.reach)?;
        match way.interface.as_deref().map(|name| (name, name.parse::<Ipv4Addr>())) {
            None => {}
            Some((_, Ok(address))) => socket.set_multicast_if_v4(&address)?,
            Some((name, Err(_))) => bind_device(&socket, name)?,
        }
        Ok(socket.into())
    };
    open().map_err(|error| match &way.interface {
        Some(interface) => format!("cannot send by {interface}: {error}; --wire-interface"),
        None => format!("cannot send: {error}"),
    })
}

#[cfg(target_os = "linux")]
fn bind_device(socket: &Socket, name: &str) -> io::Result<()> {
    socket.bind_device(Some(name.as_bytes()))
}

#[cfg(not(target_os = "linux"))]
fn bind_device(_socket: &Socket, _name: &str) -> io::Result<()> {
    Err(io::Error::new(io::ErrorKind::Unsupported, "give its IPv4 address instead of its name"))
}

/// All that arrives at a port, in batches.
///
/// # Errors
/// What the system says.
pub fn batches(
    socket: std::net::UdpSocket,
    purpose: Purpose,
) -> io::Result<LocalBoxStream<'static, Batch>> {
    let socket = Rc::new(UdpSocket::from_std(socket)?);
    let buffer = vec![0; limits::DATAGRAM_BYTES + 1];
    let arrive = move |(socket, mut buffer): (Rc<UdpSocket>, Vec<u8>)| async move {
        loop {
            // A socket that has failed for good would be asked again and again.
            socket.readable().await.ok()?;
            let datagrams = drain(&socket, &mut buffer);
            if !datagrams.is_empty() {
                let batch = Batch { purpose, datagrams, socket: socket.clone() };
                return Some((batch, (socket, buffer)));
            }
        }
    };
    Ok(stream::unfold((socket, buffer), arrive).boxed_local())
}

fn drain(socket: &UdpSocket, buffer: &mut [u8]) -> Vec<(SocketAddr, Vec<u8>)> {
    let mut datagrams = Vec::new();
    // Errors are those of an earlier answer that nobody was there to hear.
    for _ in 0..2 * BATCH {
        match socket.try_recv_from(buffer) {
            Ok((length, from)) => datagrams.push((from, buffer[..length].to_vec())),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
            Err(_) => {}
        }
        if datagrams.len() == BATCH {
            break;
        }
    }
    datagrams
}
