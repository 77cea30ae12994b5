#pragma once

/** \file
 *  \brief What is said where something is refused. */

#include <pcl/exceptions.h>

#include <gtest/gtest.h>

#include <exception>
#include <string>
#include <vector>

namespace refusal {

/** \brief The message of the exception of type Exception that action throws. */
template <typename Exception = pcl::BadArgumentException, typename Action>
std::string messageOf(const Action& action) {
  try {
    action();
  } catch (const Exception& error) {
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another exception: " << error.what();
    return "";
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

inline void expectMentions(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts)
    EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' is not in: " << message;
}

/** \brief Expects an exception of type Exception from action, whose message has all of these parts. */
template <typename Exception = pcl::BadArgumentException, typename Action>
void expectThrow(const Action& action, const std::vector<std::string>& parts) {
  expectMentions(messageOf<Exception>(action), parts);
}

}  // namespace refusal
