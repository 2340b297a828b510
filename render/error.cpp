// SPDX-License-Identifier: MIT
#include "render/error.h"

#include <system_error>

namespace skerry::render {

std::string system_message(int error) {
  return std::generic_category().message(error);
}

}  // namespace skerry::render
