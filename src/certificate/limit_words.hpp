// What broken limits are called, wherever people read of them.
#pragma once

#include <string>

namespace lamprey::certificate {

/// "limits.angle.fin is broken by 0.02 rad at 0.4 s", with the unit that the key's limit has; `violation` as LimitsKept's, `time` in s.
std::string violation_in_words(const std::string& key, double violation, double time);

}  // namespace lamprey::certificate
