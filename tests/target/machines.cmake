# The example firmware on machines other than its own, worn one; for host and target alike: a healthy one, and the healthy one with a dead time that the
# firmware's model does not know.

set(ema_ace_healthy ACE_PLANT_CSJ_NM=0.138f ACE_PLANT_BLK_MM=0.033f)
set(ema_ace_hidden ${ema_ace_healthy} ACE_PLANT_DEAD_TIME_V=0.3f)
get_target_property(folder ace SOURCE_DIR)
get_target_property(names ace SOURCES)
set(sources "")
foreach(name IN LISTS names)
    cmake_path(ABSOLUTE_PATH name BASE_DIRECTORY "${folder}")
    list(APPEND sources "${name}")
endforeach()
foreach(machine healthy hidden)
    add_executable(ace_${machine} ${sources})
    ema_compile(ace_${machine})
    target_compile_definitions(ace_${machine} PRIVATE ${ema_ace_${machine}})
    target_include_directories(ace_${machine} PRIVATE $<TARGET_PROPERTY:ace,INCLUDE_DIRECTORIES>)
    target_link_libraries(ace_${machine} PRIVATE $<TARGET_PROPERTY:ace,LINK_LIBRARIES>)
endforeach()
