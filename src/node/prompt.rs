//! The first message of a writer, which it may have sent before this node knew the writer: the
//! request of `ros2 service call`. (Nobody asks again for those on topics: readers of these are
//! best effort.)
//!
//! RustDDS 0.15.1 drops what an unknown writer sends and then asks for it by an ACKNACK with the
//! count 0, which Fast DDS passes over; the message came 3 s later, at the writer's next HEARTBEAT,
//! if it still was there. This packet is a HEARTBEAT in the writer's name, to ourselves: there is a
//! first message. RustDDS then asks for it with the next count, if it has none. A reader that has
//! heard a HEARTBEAT of the writer itself passes over this one.
//! It must never fail the caller: the message then comes when it came before.

use std::net::{Ipv4Addr, UdpSocket};

use rustdds::GUID;

use super::farewell::user_port;

/// Asks for the first message of a writer to one of our readers.
pub fn send(reader: GUID, writer: GUID, participant: (u16, u16)) {
    let (domain_id, participant_id) = participant;
    let Some(port) = user_port(domain_id, participant_id) else { return };
    let Ok(socket) = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)) else { return };
    let _ =
        socket.send_to(&packet(reader.to_bytes(), writer.to_bytes()), (Ipv4Addr::LOCALHOST, port));
}

/// Header, INFO_DST, HEARTBEAT.
fn packet(reader: [u8; 16], writer: [u8; 16]) -> Vec<u8> {
    let mut data = Vec::with_capacity(68);
    data.extend(b"RTPS\x02\x04\x01\x12");
    data.extend(&writer[..12]);
    data.extend([0x0e, 0x01, 12, 0]); // INFO_DST; little-endian
    data.extend(&reader[..12]);
    data.extend([0x07, 0x01, 28, 0]); // HEARTBEAT that wants an answer
    data.extend(&reader[12..]);
    data.extend(&writer[12..]);
    for sequence_number in [1_u32, 1] {
        data.extend(0_u32.to_le_bytes());
        data.extend(sequence_number.to_le_bytes());
    }
    data.extend(1_u32.to_le_bytes()); // the first count that counts
    data
}

#[cfg(test)]
mod tests {
    #[test]
    fn length_field_matches() {
        let packet = super::packet([7; 16], [8; 16]);
        assert_eq!(packet.len() - 40, usize::from(u16::from_le_bytes([packet[38], packet[39]])));
    }
}
