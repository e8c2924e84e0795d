//! Metadata in a file: a count, then for each item its name, its type, its size and its value.
//!
//! Source: OpenVDB, MetaMap.cc and Metadata.h.

use std::io::Read;

use crate::Error;
use crate::MetaValue;
use crate::Metadata;
use crate::input::Input;
use crate::output::push_text;
use crate::value::sealed::Bytes;

const ITEM: &str = "a metadata item";

/// Types whose name starts so exist only while OpenVDB itself reads a file.
const TEMPORARY: &str = "__";

/// Read all items.
pub(crate) fn read<R: Read>(input: &mut Input<R>) -> Result<Metadata, Error> {
    let mut metadata = Metadata::new();
    for _ in 0..input.u32("the number of metadata items")? {
        let name = input.text(ITEM)?;
        let type_name = input.text(ITEM)?;
        let n_bytes = input.u32(ITEM)?;
        let value = value(&type_name, input.bytes(n_bytes as usize, ITEM)?);
        let Some(value) = value else {
            let what = format!("the item `{name}` of type {type_name} with {n_bytes} bytes");
            return Err(input.damaged(what));
        };
        if !type_name.starts_with(TEMPORARY) {
            metadata.insert(name, value);
        }
    }
    Ok(metadata)
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
        push_text(bytes, name);
        push_value(bytes, value);
    }
}

fn push_value(bytes: &mut Vec<u8>, value: &MetaValue) {
    match value {
        MetaValue::Bool(value) => push_typed(bytes, "bool", &[u8::from(*value)]),
        MetaValue::Int32(value) => push_typed(bytes, "int32", &value.to_le_bytes()),
        MetaValue::Int64(value) => push_typed(bytes, "int64", &value.to_le_bytes()),
        MetaValue::Float(value) => push_typed(bytes, "float", &value.to_le_bytes()),
        MetaValue::Double(value) => push_typed(bytes, "double", &value.to_le_bytes()),
        MetaValue::String(text) => push_typed(bytes, "string", text.as_bytes()),
        MetaValue::Vec3i(vector) => push_typed(bytes, "vec3i", &encoded(vector)),
        MetaValue::Vec3s(vector) => push_typed(bytes, "vec3s", &encoded(vector)),
        MetaValue::Vec3d(vector) => push_typed(bytes, "vec3d", &encoded(vector)),
        MetaValue::Unknown {
            type_name,
            bytes: value,
        } => push_typed(bytes, type_name, value),
    }
}

fn encoded<T: Bytes>(vector: &[T; 3]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(3 * T::SIZE);
    for component in vector {
        component.encode(&mut bytes);
    }
    bytes
}

fn push_typed(bytes: &mut Vec<u8>, type_name: &str, value: &[u8]) {
    push_text(bytes, type_name);
    bytes.extend_from_slice(&(value.len() as u32).to_le_bytes());
    bytes.extend_from_slice(value);
}
