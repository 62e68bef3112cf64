//! FMU state, in memory and as bytes: the state of the model with mode, time, parameters and inputs of the
//! instance.
//!
//! | bytes | content |
//! |---|---|
//! | 0 – 7 | `FMI2STAT` |
//! | 8 – 11 | format version |
//! | 12 – 13 | length n of the origin |
//! | 14 – 13 + n | origin, UTF-8: model name, library and its version |
//! | 14 + n – 51 + n | GUID of the model description |
//! | 52 + n – 59 + n | length of the payload |
//! | 60 + n – 63 + n | CRC-32 of the payload |
//! | 64 + n – | payload, postcard |
//!
//! Integers are little-endian. The checks cover each byte, so any damage is refused.

use serde::{Deserialize, Serialize};

use crate::finite;
use crate::identity::{self, Difference};
use crate::settings::Settings;
use crate::state_machine::Mode;

/// State that `fmi2GetFMUstate` stores and `fmi2SetFMUstate` restores.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Snapshot<S> {
    pub instance: InstanceTime,
    pub parameters: Settings,
    pub inputs: Settings,
    pub model: S,
}

/// Mode and time of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct InstanceTime {
    pub mode: Mode,
    /// Current communication point, s.
    pub time: f64,
    /// Stop time, if the master set one, s.
    pub stop: Option<f64>,
}

const MAGIC: &[u8; 8] = b"FMI2STAT";
const VERSION: u32 = 3;

/// Model to which a state belongs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Origin {
    /// Model name, library and its version, at most 65535 bytes.
    pub name: String,
    pub guid: String,
}

impl<S: Serialize + for<'a> Deserialize<'a>> Snapshot<S> {
    /// Serialize the state.
    pub fn to_bytes(&self, origin: &Origin) -> Result<Vec<u8>, String> {
        let payload = postcard::to_stdvec(self).map_err(|error| format!("the state cannot be serialized: {error}"))?;
        Ok([
            MAGIC,
            &VERSION.to_le_bytes()[..],
            &(origin.name.len() as u16).to_le_bytes(),
            origin.name.as_bytes(),
            origin.guid.as_bytes(),
            &(payload.len() as u64).to_le_bytes(),
            &crc32fast::hash(&payload).to_le_bytes(),
            &payload,
        ]
        .concat())
    }

    /// Read a state of this origin; refuse damage and states of another origin.
    pub fn from_bytes(bytes: &[u8], origin: &Origin) -> Result<Self, String> {
        let mut rest = bytes;
        if take::<8>(&mut rest)? != *MAGIC {
            return Err("the bytes are not a serialized FMU state".into());
        }
        let version = u32::from_le_bytes(take(&mut rest)?);
        if version != VERSION {
            return Err(format!("the serialized state has the format version {version}, not {VERSION}"));
        }
        let length = u16::from_le_bytes(take(&mut rest)?).into();
        let Some((name, after)) = rest.split_at_checked(length) else {
            return Err(format!("the serialized state ends {} bytes early", length - rest.len()));
        };
        rest = after;
        let (name, Origin { name: own, guid }) = (String::from_utf8_lossy(name), origin);
        if name != own.as_str() {
            return Err(format!("the serialized state belongs to {name}, not to {own}"));
        }
        let theirs = take::<{ identity::LENGTH }>(&mut rest)?;
        if theirs != guid.as_bytes() {
            let theirs = String::from_utf8_lossy(&theirs);
            let what = match identity::difference(&theirs, guid) {
                Some(Difference::Resources) => "with other resources",
                _ => "with another model description",
            };
            return Err(format!("the serialized state belongs to {own} {what}: its GUID is {theirs}, not {guid}"));
        }
        let length = u64::from_le_bytes(take(&mut rest)?);
        let checksum = u32::from_le_bytes(take(&mut rest)?);
        if length != rest.len() as u64 {
            return Err(format!("the serialized state holds {} bytes, not {length}", rest.len()));
        }
        if checksum != crc32fast::hash(rest) {
            return Err("the serialized state is damaged: the checksum is wrong".into());
        }
        match postcard::take_from_bytes(rest) {
            Ok((snapshot, [])) => {
                finite::check(&snapshot).map_err(|why| format!("the serialized state is damaged: {why}"))?;
                Ok(snapshot)
            }
            Ok((_, left)) => Err(format!("the serialized state has {} bytes too many", left.len())),
            Err(error) => Err(format!("the serialized state cannot be read: {error}")),
        }
    }
}

/// Take `N` bytes off the front.
fn take<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], String> {
    let (head, tail) =
        rest.split_first_chunk().ok_or_else(|| format!("the serialized state ends {} bytes early", N - rest.len()))?;
    *rest = tail;
    Ok(*head)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin() -> Origin {
        Origin { name: "Tank by tank 1.0".into(), guid: "{01234567-89ab-cdef-0123-456789abcdef}".into() }
    }

    fn snapshot() -> Snapshot<Vec<f64>> {
        let instance = InstanceTime { mode: Mode::StepComplete, time: 0.1, stop: Some(2.0) };
        let (parameters, inputs) = (Settings::default(), Settings::default());
        Snapshot { instance, parameters, inputs, model: vec![-0.0, 1e-300, std::f64::consts::PI] }
    }

    fn read(bytes: &[u8]) -> Result<Snapshot<Vec<f64>>, String> {
        Snapshot::from_bytes(bytes, &origin())
    }

    #[test]
    fn bytes_read_back_to_the_same_state() {
        assert_eq!(read(&snapshot().to_bytes(&origin()).unwrap()), Ok(snapshot()));
    }

    #[test]
    fn a_change_of_any_byte_is_refused() {
        let bytes = snapshot().to_bytes(&origin()).unwrap();
        for at in 0..bytes.len() {
            for mask in [0x01, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[at] ^= mask;
                assert!(read(&damaged).is_err(), "byte {at} changed by {mask:#x} was accepted");
            }
        }
    }

    #[test]
    fn numbers_that_are_not_finite_are_refused_by_their_place() {
        let bytes = |change: &dyn Fn(&mut Snapshot<Vec<f64>>)| {
            let mut damaged = snapshot();
            change(&mut damaged);
            read(&damaged.to_bytes(&origin()).unwrap()).unwrap_err()
        };
        for (message, part) in [
            (bytes(&|state| state.model[1] = f64::NAN), "damaged: model has NaN"),
            (bytes(&|state| state.instance.time = f64::INFINITY), "damaged: instance.time has inf"),
            (bytes(&|state| state.instance.stop = Some(f64::NAN)), "damaged: instance.stop has NaN"),
        ] {
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn a_cut_or_an_addition_of_any_length_is_refused() {
        let bytes = snapshot().to_bytes(&origin()).unwrap();
        for length in 0..bytes.len() {
            assert!(read(&bytes[..length]).is_err(), "{length} of {} bytes were accepted", bytes.len());
        }
        assert!(read(&[&bytes[..], &[0]].concat()).is_err());
    }

    #[test]
    fn a_state_of_another_origin_is_refused_with_what_differs() {
        let Origin { name, guid } = origin();
        let (other, edited) = (name.replace("1.0", "2.0"), guid.replace("89ab", "f9ab"));
        for (state, parts) in [
            (Origin { name: other.clone(), guid: guid.clone() }, [&other[..], &name]),
            (Origin { name: name.clone(), guid: edited.clone() }, [&edited, "other resources"]),
            (Origin { name: name.clone(), guid: guid.replace("def}", "d0f}") }, ["another model description", &guid]),
        ] {
            let message = read(&snapshot().to_bytes(&state).unwrap()).unwrap_err();
            assert!(parts.iter().all(|part| message.contains(part)), "{message}");
        }
    }
}
