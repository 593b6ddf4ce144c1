#include "components/runtime/logic/offences.h"

#include <gtest/gtest.h>

namespace rack {
namespace {

TEST(OffencePlaces, CountsEachPlaceAndTellsNewOnes) {
  OffencePlaces places;
  EXPECT_TRUE(places.add(Offence::kBlocked, "nap"));
  EXPECT_TRUE(places.add(Offence::kPageFault, "nap")) << "another offence";
  EXPECT_TRUE(places.add(Offence::kBlocked, "read"));
  EXPECT_FALSE(places.add(Offence::kBlocked, "read"));
  const auto worst = places.worst(2);
  ASSERT_EQ(worst.size(), 2U);
  EXPECT_EQ(worst[0].text, "read");
  EXPECT_EQ(worst[0].count, 2U);
  EXPECT_EQ(worst[1].text, "nap");
}

TEST(OffencePlaces, KeepsTheFirstWhenThereAreTooMany) {
  OffencePlaces places;
  for (std::size_t i = 0; i < OffencePlaces::kMax; ++i)
    EXPECT_TRUE(places.add(Offence::kBlocked, std::to_string(i)));
  EXPECT_FALSE(places.add(Offence::kBlocked, "one more"));
  EXPECT_FALSE(places.add(Offence::kBlocked, "0"));
  EXPECT_EQ(places.worst(1).at(0).count, 2U);
}

TEST(PlaceText, GoesFromTheInnermostToTheOutermost) {
  const std::vector<std::string> functions = {"nanosleep",
                                              "Sweeper::nap(int)",
                                              "std::function<void ()>::operator()() const",
                                              "Sweeper::module_loop()",
                                              "run()",
                                              "main"};
  EXPECT_EQ(place_text(functions, "run", 100), "nanosleep < Sweeper::nap < Sweeper::module_loop");
  EXPECT_EQ(place_text(functions, "run", 30), "nanosleep < Sweeper::nap");
  EXPECT_EQ(place_text(functions, "run", 4), "nano");
  EXPECT_EQ(place_text({}, "run", 100), "");
}

TEST(PlaceText, TellsOfTheStandardLibraryOnlyWhereItBegins) {
  const std::vector<std::string> functions = {"void std::vector<int>::grow<int>(int&&)",
                                              "std::vector<int>::push_back(int)", "look(int)"};
  EXPECT_EQ(place_text(functions, "run", 100), "void std::vector<int>::grow<int> < look");
}

TEST(WithoutParameters, KeepsParenthesesOfNames) {
  EXPECT_EQ(without_parameters("rack::(anonymous namespace)::Sweeper::look(int) const"),
            "rack::(anonymous namespace)::Sweeper::look");
  EXPECT_EQ(without_parameters("each(void (*)(int), int)"), "each");
  EXPECT_EQ(without_parameters("Sweeper::operator()(int)"), "Sweeper::operator()");
  EXPECT_EQ(without_parameters("(anonymous namespace)::main_loop"),
            "(anonymous namespace)::main_loop");
  EXPECT_EQ(without_parameters("usleep"), "usleep");
  EXPECT_EQ(without_parameters("damaged)"), "damaged)");
  EXPECT_EQ(without_parameters(""), "");
}

}  // namespace
}  // namespace rack
