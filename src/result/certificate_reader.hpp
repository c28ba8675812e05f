// The certificate of a solution.json.
#pragma once

#include "certificate/certificate.hpp"
#include "document/json_document.hpp"

namespace lamprey::result {

/// Of a swimmer of so many bodies. Throws model::InputError with the place of what is missing or of another kind.
certificate::Certificate read_certificate(const document::JsonReader& reader, int bodies);

}  // namespace lamprey::result
