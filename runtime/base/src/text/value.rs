//! Deserializer of structs from parsed TOML. The one of the `toml` crate compiles the code of every struct four times (for
//! tables, spans, dates and values), this one once.

use serde::de::value::StrDeserializer;
use serde::de::{DeserializeSeed, Deserializer, EnumAccess, Error as _, IntoDeserializer};
use serde::de::{MapAccess, SeqAccess, VariantAccess, Visitor};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeString, DeValue};

/// Fault of a text, with its place where that is known.
#[derive(Debug)]
pub(super) struct Fault {
    pub why: String,
    pub span: Option<Range<usize>>,
}

impl Fault {
    /// Fault with a place, which stays as it is where it has one already.
    fn at(self, span: &Range<usize>) -> Self {
        Self { span: self.span.or_else(|| Some(span.clone())), ..self }
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.why)
    }
}

impl std::error::Error for Fault {}

impl serde::de::Error for Fault {
    fn custom<T: std::fmt::Display>(why: T) -> Self {
        Self { why: why.to_string(), span: None }
    }
}

/// Value with its range of bytes in the text.
pub(super) struct Value<'t> {
    pub value: &'t DeValue<'t>,
    pub span: Range<usize>,
}

impl<'t> From<&'t Spanned<DeValue<'t>>> for Value<'t> {
    fn from(value: &'t Spanned<DeValue<'t>>) -> Self {
        Self { span: value.span(), value: value.get_ref() }
    }
}

type Entries<'t> = dyn Iterator<Item = (&'t Spanned<DeString<'t>>, &'t Spanned<DeValue<'t>>)> + 't;

impl<'de> Deserializer<'de> for Value<'_> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        let span = self.span;
        match self.value {
            DeValue::String(s) => visitor.visit_str(s),
            DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
                Ok(value) => visitor.visit_i64(value),
                Err(_) => match u64::from_str_radix(i.as_str(), i.radix()) {
                    Ok(value) => visitor.visit_u64(value),
                    Err(_) => Err(Fault::custom(format!("{} needs more than 64 bits", i.as_str()))),
                },
            },
            DeValue::Float(f) => match f.as_str().parse::<f64>() {
                Ok(value) if value.is_finite() || f.as_str().contains(['i', 'n']) => visitor.visit_f64(value),
                _ => Err(Fault::custom(format!("{} is beyond the range of numbers", f.as_str()))),
            },
            DeValue::Boolean(b) => visitor.visit_bool(*b),
            DeValue::Datetime(d) => visitor.visit_str(&d.to_string()),
            DeValue::Array(items) => visitor.visit_seq(Items(items.iter())),
            DeValue::Table(table) => visitor.visit_map(Fields { rest: Box::new(table.iter()), value: None }),
        }
        .map_err(|e| e.at(&span))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_newtype_struct(self)
    }

    /// Reads a string as a variant without content, and a table with one key as a variant with content.
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        let span = self.span.clone();
        match self.value {
            DeValue::String(name) => visitor.visit_enum(Variant { name, span: self.span, content: None }),
            DeValue::Table(table) if table.len() == 1 => {
                let (name, content) = table.iter().next().expect("one");
                visitor.visit_enum(Variant { name: name.get_ref(), span: name.span(), content: Some(content.into()) })
            }
            DeValue::Table(table) => {
                Err(Fault::custom(format!("expected a table with one key, found {}", table.len())))
            }
            _ => Err(Fault::custom("expected a string, or a table with one key")),
        }
        .map_err(|e| e.at(&span))
    }

    serde::forward_to_deserialize_any! {
        bool u8 u16 u32 u64 u128 i8 i16 i32 i64 i128 f32 f64 char str string seq bytes byte_buf map unit
        ignored_any unit_struct tuple_struct tuple identifier struct
    }
}

struct Items<'t>(std::slice::Iter<'t, Spanned<DeValue<'t>>>);

impl<'de> SeqAccess<'de> for Items<'_> {
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Fault> {
        self.0.next().map(|item| seed.deserialize(Value::from(item)).map_err(|e| e.at(&item.span()))).transpose()
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

struct Fields<'t> {
    rest: Box<Entries<'t>>,
    value: Option<Value<'t>>,
}

impl<'de> MapAccess<'de> for Fields<'_> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Fault> {
        let Some((key, value)) = self.rest.next() else { return Ok(None) };
        self.value = Some(value.into());
        seed.deserialize(name(key.get_ref())).map(Some).map_err(|e| e.at(&key.span()))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        let value = self.value.take().expect("a key was read");
        let span = value.span.clone();
        seed.deserialize(value).map_err(|e| e.at(&span))
    }
}

fn name(name: &str) -> StrDeserializer<'_, Fault> {
    name.into_deserializer()
}

struct Variant<'t> {
    name: &'t str,
    span: Range<usize>,
    content: Option<Value<'t>>,
}

impl<'de, 't> EnumAccess<'de> for Variant<'t> {
    type Error = Fault;
    type Variant = Content<'t>;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Content<'t>), Fault> {
        let variant = seed.deserialize(name(self.name)).map_err(|e| e.at(&self.span))?;
        Ok((variant, Content { name: self.name, value: self.content }))
    }
}

struct Content<'t> {
    name: &'t str,
    value: Option<Value<'t>>,
}

impl<'t> Content<'t> {
    fn needed(self) -> Result<Value<'t>, Fault> {
        self.value.ok_or_else(|| Fault::custom(format!("`{0}` needs content: {{ {0} = ... }}", self.name)))
    }
}

impl<'de> VariantAccess<'de> for Content<'_> {
    type Error = Fault;

    fn unit_variant(self) -> Result<(), Fault> {
        match self.value {
            None => Ok(()),
            Some(_) => Err(Fault::custom(format!("`{0}` has no content: write \"{0}\"", self.name))),
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Fault> {
        seed.deserialize(self.needed()?)
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Fault> {
        self.needed()?.deserialize_any(visitor)
    }

    fn struct_variant<V: Visitor<'de>>(self, fields: &'static [&'static str], visitor: V) -> Result<V::Value, Fault> {
        let content = self.needed()?;
        if let DeValue::Table(table) = content.value
            && let Some((key, _)) = table.iter().find(|(key, _)| !fields.contains(&key.get_ref().as_ref()))
        {
            return Err(Fault::unknown_field(key.get_ref(), fields).at(&key.span()));
        }
        content.deserialize_any(visitor)
    }
}
