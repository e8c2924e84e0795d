//! Metadata in a file: a count, then for each item its name, its type, its size and its value.
//!
//! Source: OpenVDB, MetaMap.cc and Metadata.h.

use crate::Error;
use crate::MetaValue;
use crate::Metadata;
use crate::source::Source;
use crate::value::sealed::Bytes;

const ITEM: &str = "a metadata item";

/// Types whose name starts so exist only while OpenVDB itself reads a file.
const TEMPORARY: &str = "__";

/// An item as it stands in a file.
struct RawItem {
    name: Vec<u8>,
    type_name: Vec<u8>,
    value: Vec<u8>,
}

/// Read all items.
pub(crate) fn read(input: &mut impl Source) -> Result<Metadata, Error> {
    let mut metadata = Metadata::new();
    for _ in 0..input.u32("the number of metadata items")? {
        let item = raw_item(input)?;
        let name = String::from_utf8_lossy(&item.name).into_owned();
        let type_name = String::from_utf8_lossy(&item.type_name);
        let Some(value) = value(&type_name, &item.value) else {
            let n_bytes = item.value.len();
            let what = format!("the item `{name}` of type {type_name} with {n_bytes} bytes");
            return Err(input.damaged(what));
        };
        if !type_name.starts_with(TEMPORARY) {
            metadata.insert(name, value);
        }
    }
    Ok(metadata)
}

fn raw_item(input: &mut impl Source) -> Result<RawItem, Error> {
    let mut text = || {
        let n_bytes = input.u32(ITEM)?;
        Ok::<_, Error>(input.bytes(n_bytes as usize, ITEM)?.to_vec())
    };
    Ok(RawItem {
        name: text()?,
        type_name: text()?,
        value: text()?,
    })
}

/// Nothing if the value has not the size of its type.
fn value(type_name: &str, bytes: &[u8]) -> Option<MetaValue> {
    Some(match type_name {
        "bool" => MetaValue::Bool(one(bytes)?),
        "int32" => MetaValue::Int32(one(bytes)?),
        "int64" => MetaValue::Int64(i64::from_le_bytes(bytes.try_into().ok()?)),
        "float" => MetaValue::Float(one(bytes)?),
        "double" => MetaValue::Double(one(bytes)?),
        "string" => match std::str::from_utf8(bytes) {
            Ok(text) => MetaValue::String(text.to_owned()),
            Err(_) => unknown(type_name, bytes),
        },
        "vec3i" => MetaValue::Vec3i(three(bytes)?),
        "vec3s" => MetaValue::Vec3s(three(bytes)?),
        "vec3d" => MetaValue::Vec3d(three(bytes)?),
        _ => unknown(type_name, bytes),
    })
}

fn unknown(type_name: &str, bytes: &[u8]) -> MetaValue {
    MetaValue::Unknown {
        type_name: type_name.to_owned(),
        bytes: bytes.to_vec(),
    }
}

fn one<T: Bytes>(bytes: &[u8]) -> Option<T> {
    (bytes.len() == T::SIZE).then(|| T::decode(bytes))
}

fn three<T: Bytes>(bytes: &[u8]) -> Option<[T; 3]> {
    let sound = bytes.len() == 3 * T::SIZE;
    sound.then(|| [0, 1, 2].map(|index| T::decode(&bytes[index * T::SIZE..(index + 1) * T::SIZE])))
}

/// Append all items.
pub(crate) fn push(bytes: &mut Vec<u8>, metadata: &Metadata) {
    bytes.extend_from_slice(&(metadata.len() as u32).to_le_bytes());
    for (name, value) in metadata.iter() {
        let (type_name, value) = encoded(value);
        for part in [name.as_bytes(), type_name.as_bytes(), &value] {
            bytes.extend_from_slice(&(part.len() as u32).to_le_bytes());
            bytes.extend_from_slice(part);
        }
    }
}

/// Type and bytes of a value.
fn encoded(value: &MetaValue) -> (&str, Vec<u8>) {
    match value {
        MetaValue::Bool(value) => ("bool", vec![u8::from(*value)]),
        MetaValue::Int32(value) => ("int32", value.to_le_bytes().to_vec()),
        MetaValue::Int64(value) => ("int64", value.to_le_bytes().to_vec()),
        MetaValue::Float(value) => ("float", value.to_le_bytes().to_vec()),
        MetaValue::Double(value) => ("double", value.to_le_bytes().to_vec()),
        MetaValue::String(text) => ("string", text.as_bytes().to_vec()),
        MetaValue::Vec3i(vector) => ("vec3i", components(vector)),
        MetaValue::Vec3s(vector) => ("vec3s", components(vector)),
        MetaValue::Vec3d(vector) => ("vec3d", components(vector)),
        MetaValue::Unknown { type_name, bytes } => (type_name, bytes.clone()),
    }
}

fn components<T: Bytes>(vector: &[T; 3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    T::encode_all(vector, &mut bytes);
    bytes
}
