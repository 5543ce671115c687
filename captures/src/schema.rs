//! The protobuf schemas stored in each MCAP.

use super::messages::{OutageMessage, RawBytes, StationEvent, Telemetry, UplinkEvent};
use super::own_lines::Values;

/// `FileDescriptorSet` compiled from `proto/groundwave.proto`; a test compares it with the text.
pub const DESCRIPTORS: &[u8] = include_bytes!("proto/groundwave.binpb");

/// A message type with a schema.
pub trait Schema: prost::Message {
    /// Full name of the message type, with its package.
    const NAME: &str;
}

impl Schema for RawBytes {
    const NAME: &str = "groundwave.RawBytes";
}

impl Schema for Telemetry {
    const NAME: &str = "groundwave.Telemetry";
}

impl Schema for UplinkEvent {
    const NAME: &str = "groundwave.UplinkEvent";
}

impl Schema for OutageMessage {
    const NAME: &str = "groundwave.Outage";
}

impl Schema for Values {
    const NAME: &str = "groundwave.Values";
}

impl Schema for StationEvent {
    const NAME: &str = "groundwave.StationEvent";
}

#[cfg(test)]
mod tests {
    use super::*;
    use prost::Message;
    use prost_types::field_descriptor_proto::{Label, Type};
    use prost_types::{DescriptorProto, FileDescriptorProto, FileDescriptorSet};

    fn file() -> FileDescriptorProto {
        let mut set = FileDescriptorSet::decode(DESCRIPTORS).unwrap();
        assert_eq!(set.file.len(), 1);
        set.file.remove(0)
    }

    fn message<M: Schema>(file: &FileDescriptorProto) -> DescriptorProto {
        let name = M::NAME.strip_prefix("groundwave.").unwrap();
        let found = file.message_type.iter().find(|m| m.name() == name);
        found.unwrap().clone()
    }

    /// Compares the stored descriptors with the text; `BLESS=1 cargo test -p groundwave-captures schema` compiles them again.
    #[test]
    fn the_descriptors_are_the_text_compiled() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/proto");
        let mut compiler = protox::Compiler::new([folder]).unwrap();
        compiler.include_source_info(false).include_imports(true);
        let compiled = compiler
            .open_file("groundwave.proto")
            .unwrap()
            .file_descriptor_set()
            .encode_to_vec();
        if std::env::var_os("BLESS").is_some() {
            std::fs::write(format!("{folder}/groundwave.binpb"), &compiled).unwrap();
        } else {
            assert!(
                compiled == DESCRIPTORS,
                "compile the descriptors again: BLESS=1 cargo test -p groundwave-captures schema"
            );
        }
    }

    #[test]
    fn the_text_declares_the_fields_that_rust_writes() {
        let file = file();
        let raw = message::<RawBytes>(&file);
        let raw: Vec<_> = raw
            .field
            .iter()
            .map(|f| (f.name(), f.number(), f.r#type()))
            .collect();
        assert_eq!(
            raw,
            [("stream_offset", 1, Type::Uint64), ("data", 2, Type::Bytes)]
        );
        let telemetry = message::<Telemetry>(&file);
        assert_eq!(telemetry.field.len(), Telemetry::FIELDS.len());
        for (declared, field) in telemetry.field.iter().zip(Telemetry::FIELDS) {
            assert_eq!(declared.name(), field.name);
            assert_eq!(declared.number(), field.tag as i32, "{}", field.name);
            assert_eq!(declared.label(), Label::Optional);
            assert!(declared.proto3_optional(), "{}", field.name);
            let expected = match field.kind {
                "int32" => Type::Enum,
                "sint32" => Type::Sint32,
                "uint32" => Type::Uint32,
                "double" => Type::Double,
                "string" => Type::String,
                kind => panic!("{kind}"),
            };
            assert_eq!(declared.r#type(), expected, "{}", field.name);
            if expected == Type::Enum {
                let name = declared.type_name().strip_prefix(".groundwave.").unwrap();
                let states = file.enum_type.iter().find(|e| e.name() == name).unwrap();
                let declared: Vec<_> = states
                    .value
                    .iter()
                    .map(|v| (v.number(), v.name().to_owned()))
                    .collect();
                let prefix = declared[0]
                    .1
                    .strip_suffix(&field.words[0].to_uppercase())
                    .unwrap();
                let words: Vec<_> = (0..)
                    .zip(
                        field
                            .words
                            .iter()
                            .map(|w| format!("{prefix}{}", w.to_uppercase())),
                    )
                    .collect();
                assert_eq!(declared, words);
            }
        }
    }
}
